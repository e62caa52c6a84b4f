#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "common/math/pose.h"
#include "common/step_tuning.h"
#include "scenes/effects/effects.h"
#include "scenes/sphere_tree.h"

namespace palpate {

/// Triangle mesh in metres.  Faces are counter-clockwise seen from outside.
struct TriangleMesh {
  std::vector<Vec3> vertices;  ///< mesh frame [m]
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// What a part of a body is made of: properties of the leaves of its sphere tree (chapter 2.2.3).
/// Only objects' count; a tool has none of its own.
struct Material {
  /// Row stiffness of a leaf's contact [N/m]; infinite: rigid.
  double stiffness = std::numeric_limits<double>::infinity();
  double static_friction = 0.0;   ///< mu_s
  double dynamic_friction = 0.0;  ///< mu_d <= mu_s
  // Of bodies that burs cut (Body::grid; server/physics/cut/README.md has the law):
  double cutting_pressure = 0.0;     ///< p_0 [Pa]: up to it an edge does not enter; 0: no such body
  double cutting_viscosity = 0.0;    ///< kappa [Pa s/m]: what each m/s of the edge adds
  double cutting_friction = 0.0;     ///< mu_c: of a bur that spins
  std::string name{};                ///< what people call it, as "dentine"; several may have one
  std::uint32_t colour = kNoColour;  ///< 0xRRGGBB of what a cut lays bare
  static constexpr std::uint32_t kNoColour = 1u << 24;  ///< viewers choose
};

/// A part of a body that is of another material.
struct MaterialRegion {
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  ///< a box in frame B [m]; or, where radius > 0:
  double radius = 0.0;                           ///< a ball round `low`
  std::uint8_t material = 0;
  TriangleMesh
      mesh{};  ///< or, where it has triangles, what lies within it (CheckEncloses); frame B

  /// Of a box or a ball.
  bool Holds(const Vec3& p_B) const {
    return radius > 0.0 ? (p_B - low).norm() <= radius
                        : (p_B.array() >= low.array()).all() && (p_B.array() <= high.array()).all();
  }
};

/// A body that burs cut is a distance grid (scenes/grid).
struct BodyGrid {
  double spacing = 50e-6;  ///< [m]
  std::vector<MaterialRegion>
      regions;  ///< later ones over earlier ones; the rest is of materials[0]
};

/// How a bur turns.
struct BurSpin {
  double speed = 0.0;     ///< clockwise seen from its shank [rad/s]
  double tooth_Hz = 0.0;  ///< how many of its teeth pass in a second
  double hum = 0.0;       ///< with each, the handle shakes by this share of the cutting force
};

/// An edge, as a scaler's: a profile in a tool of any shape, which cuts where it is drawn in a
/// sense.
struct EdgePlace {
  Vec3 at = Vec3::Zero();      ///< where the curve has z = 0, in frame B [m]
  Vec3 along = Vec3::UnitY();  ///< unit: the axis, from the tip on
  Vec3 sense = Vec3::UnitZ();  ///< unit: where the hand has to draw it
};

/// The cutting part of a tool: what a convex curve (rho, z) sweeps that turns round its axis, made
/// thicker by the rounding [m].  Of a bur the tip is the origin of frame B, and the axis is its y.
struct BurProfile {
  std::vector<std::array<double, 2>> curve;
  double rounding = 0.0;
  double dead_tip = 0.0;  ///< what lies so near the tip, along the axis, does not cut [m]
  double cutting = 0.0;   ///< nor what lies farther from it than this [m]; 0: all else cuts
  BurSpin spin{};
  std::optional<EdgePlace> edge{};  ///< none: a bur
};

/// A rigid body of the scene: its mesh and its sphere tree share one frame B.
struct Body {
  std::string name;
  TriangleMesh mesh;  ///< frame B [m]
  SphereTree tree;    ///< frame B [m]
  /// Material of each leaf, as an index into `materials`; empty: all are of materials[0].
  std::vector<std::uint8_t> leaf_material;
  std::vector<Material> materials{Material{}};
  Pose X_WB{};         ///< objects: where they stand.  Tools: where the tool starts.
  std::string look{};  ///< what viewers draw it as; empty: what its material is
  /// Share of the room that each vertex sees, 0 to 255 (ambient_light.h); empty: all of it.
  std::vector<std::uint8_t> ambient{};
  /// Of gum: the margin round its tooth, closed, counter-clockwise seen from the chewing surface,
  /// in frame B [m]; empty: not known.  What probing depth is measured from.
  std::vector<Vec3> margin{};
  std::optional<BodyGrid> grid{};   ///< objects: of one that burs cut
  std::optional<BurProfile> bur{};  ///< tools: of one that cuts
  /// What was mended of its mesh when it was read, for people: a sentence each.
  std::vector<std::string> remarks{};
};

enum class ContactModel : std::uint8_t {
  kSpheres,  ///< the chapter's: the leaves of tool and objects must not overlap
  kSurface,  ///< the meshes must not
};
enum class FrictionModel : std::uint8_t {
  kOff,
  kChapter,  ///< 2.25-2.34, for reproduction
  kCoulomb,  ///< the frictional step
};

/// What the step of a scene is composed of when the scene loads; what is off costs nothing.
struct Features {
  ContactModel contact = ContactModel::kSurface;
  FrictionModel friction = FrictionModel::kOff;
  bool compliance = false;  ///< finite Material::stiffness counts
};

/// The virtual coupling between haptic and graphic tool (chapter 2.3: G, eqs. 2.20-2.24).
struct Coupling {
  double stiffness = 1000.0;         ///< k_t [N/m]
  double torsional_stiffness = 1.0;  ///< k_r [N m/rad]
};

/// From where a viewer looks at first: along -from at a ball, which fills the picture.
struct FirstSight {
  Vec3 centre = Vec3::Zero();  ///< W [m]
  double radius = 0.0;         ///< [m]
  Vec3 from = Vec3::UnitZ();   ///< unit
};

/// A scene, compiled: what the server loads and the wire carries (scene_bundle.h).  Immutable.
struct Scene {
  std::string name;
  std::vector<Body> tools;    ///< moved by hands, one station each
  std::vector<Body> objects;  ///< fixed in W
  Coupling coupling;
  StepTuning tuning;
  Features features;
  std::vector<Effect> effects;            ///< forces of one's own
  std::optional<FirstSight> first_sight;  ///< none: all the objects
};

}  // namespace palpate
