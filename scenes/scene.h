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
#include "scenes/moved_group.h"
#include "scenes/sphere_tree.h"

namespace palpate {

/// Triangle mesh in metres.  Faces are counter-clockwise seen from outside.
struct TriangleMesh {
  std::vector<Vec3> vertices;  ///< mesh frame [m]
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// What a part of a body is made of: the properties of the leaves of its sphere tree (chapter
/// 2.2.3).  A tool's is only what other tools feel of it (Scene::hands_meet): its friction.
struct Material {
  /// Stiffness of a leaf's contact row [N/m]; infinite: rigid.
  double stiffness = std::numeric_limits<double>::infinity();
  double static_friction = 0.0;   ///< mu_s
  double dynamic_friction = 0.0;  ///< mu_d <= mu_s
  // For bodies that burs cut (Body::grid; server/physics/cut/README.md has the law):
  double cutting_pressure = 0.0;     ///< p_0 [Pa]: up to it an edge does not cut in; 0: not cut
  double cutting_viscosity = 0.0;    ///< kappa [Pa s/m]: pressure added per m/s of the edge's speed
  double cutting_friction = 0.0;     ///< mu_c: friction of a spinning bur
  std::string name{};                ///< for people, as "dentine"; several may share one
  std::uint32_t colour = kNoColour;  ///< 0xRRGGBB of a surface that a cut exposes
  static constexpr std::uint32_t kNoColour = 1u << 24;  ///< the viewer chooses
};

/// A part of a body that has another material: a box, a ball or a closed mesh.
struct MaterialRegion {
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();  ///< a box in frame B [m]; if radius > 0:
  double radius = 0.0;                           ///< a ball round `low`
  std::uint8_t material = 0;
  TriangleMesh mesh{};  ///< if it has triangles: what lies within it (CheckEncloses); frame B

  /// Returns whether a box or a ball contains the point.  Not for meshes.
  bool Holds(const Vec3& p_B) const {
    return radius > 0.0 ? (p_B - low).norm() <= radius
                        : (p_B.array() >= low.array()).all() && (p_B.array() <= high.array()).all();
  }
};

/// The distance grid of a body that burs cut (scenes/grid).
struct BodyGrid {
  double spacing = 50e-6;  ///< [m]
  std::vector<MaterialRegion>
      regions;  ///< a later one overrides earlier ones; elsewhere materials[0]
};

/// The rotation of a bur.
struct BurSpin {
  double speed = 0.0;      ///< clockwise seen from its shank [rad/s]
  double tooth_Hz = 0.0;   ///< teeth that pass per second
  double vibration = 0.0;  ///< share of the cutting force by which each tooth shakes the handle
};

/// A cutting edge, as a scaler's: a profile in a tool of any shape that cuts when it is drawn
/// in one direction.
struct EdgePlace {
  Vec3 at = Vec3::Zero();      ///< point of the axis where the profile has z = 0, in frame B [m]
  Vec3 along = Vec3::UnitY();  ///< unit: direction of the axis, away from the tip
  Vec3 sense = Vec3::UnitZ();  ///< unit: direction in which the hand has to draw it
};

/// The cutting part of a tool: the solid that a convex curve (rho, z) sweeps when it turns round
/// its axis, thickened by the rounding [m].  For a bur the tip is the origin of frame B, and the
/// axis is y.
struct BurProfile {
  std::vector<std::array<double, 2>> curve;
  double rounding = 0.0;
  double dead_tip = 0.0;  ///< the part this near the tip, along the axis, does not cut [m]
  /// the part farther from the tip than this does not either [m]; 0: no limit
  double cutting = 0.0;
  BurSpin spin{};
  std::optional<EdgePlace> edge{};  ///< none: it is a bur
};

/// A rigid body of the scene; its mesh and its sphere tree share one frame B.
struct Body {
  std::string name;
  TriangleMesh mesh;  ///< frame B [m]
  SphereTree tree;    ///< frame B [m]
  /// Material of each leaf, as an index into `materials`; empty: all have materials[0].
  std::vector<std::uint8_t> leaf_material;
  std::vector<Material> materials{Material{}};
  Pose X_WB{};  ///< objects: the pose.  Tools: the start pose.
  /// Objects: number of the group of Scene::moved that it belongs to, from 1; 0: it stands still.
  std::uint32_t moved = 0;
  std::string look{};  ///< what viewers draw it as; empty: what its material is
  /// Share of the surrounding space that each vertex sees, 0 to 255 (ambient_light.h); empty: all.
  std::vector<std::uint8_t> ambient{};
  /// For gum: the margin round its tooth, from which probing depth is measured; a closed curve,
  /// counter-clockwise seen from the chewing surface, in frame B [m]; empty: unknown.
  std::vector<Vec3> margin{};
  std::optional<BodyGrid> grid{};   ///< only for objects that burs cut
  std::optional<BurProfile> bur{};  ///< only for tools that cut
  /// What was repaired in its mesh when it was read, for people: a sentence each.
  std::vector<std::string> remarks{};
};

enum class ContactModel : std::uint8_t {
  kSpheres,  ///< chapter 2: the leaves of the tool's and the objects' trees must not overlap
  kSurface,  ///< the tool's and the objects' meshes must not overlap
};
enum class FrictionModel : std::uint8_t {
  kOff,
  kChapter,  ///< chapter 2, eqs. 2.25-2.34, for reproduction
  kCoulomb,  ///< Coulomb's law (server/physics/solve/friction.md)
};

/// The parts of a scene's haptic step, chosen when the scene loads; a part that is off
/// costs no time.
struct Features {
  ContactModel contact = ContactModel::kSurface;
  FrictionModel friction = FrictionModel::kOff;
  bool compliance = false;  ///< whether a finite Material::stiffness counts
};

/// The virtual coupling between haptic and graphic tool (chapter 2.3: G, eqs. 2.20-2.24).
struct Coupling {
  double stiffness = 1000.0;         ///< k_t [N/m]
  double torsional_stiffness = 1.0;  ///< k_r [N m/rad]
};

/// The first view of the scene: along -from, at a ball that fills the picture.
struct FirstSight {
  Vec3 centre = Vec3::Zero();  ///< W [m]
  double radius = 0.0;         ///< [m]
  Vec3 from = Vec3::UnitZ();   ///< unit
};

/// Most tools of a scene whose hands meet.
inline constexpr std::size_t kMostHands = 4;
/// Most hands and free bodies that move together.
inline constexpr std::size_t kMostMembers = 8;

/// A compiled scene: what the server loads, and what is sent to others
/// (scene_bundle.h).  Immutable.
struct Scene {
  std::string name;
  std::vector<Body> tools;    ///< moved by hands, one station each
  std::vector<Body> objects;  ///< fixed in W, but for those of a group
  std::vector<MovedGroup> moved{};
  /// Whether tools touch each other, and all hands act in one world; else each is alone with the
  /// objects.
  bool hands_meet = false;
  Vec3 gravity = Vec3::Zero();  ///< of free bodies [m/s^2]
  Coupling coupling;
  StepTuning tuning;
  Features features;
  std::vector<Effect> effects;            ///< forces that the scene adds
  std::optional<FirstSight> first_sight;  ///< none: a view of all objects
};

}  // namespace palpate
