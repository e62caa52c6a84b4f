#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/math/pose.h"
#include "scenes/scene.h"

namespace palpate::test {

/// Says whether what pulls a tool at a pose is borne by the contacts there, and how much is not.
/// It takes triangles and poses, and shares no code with the physics.
///
/// A pose is an answer of the step (the nearest pose at a small distance from the true geometry)
/// only if the spring's pull lies in the cone of the wrenches of the contacts.  A contact is a pair
/// of features (corner, edge or face) of tool and object that are near, along a direction that lies
/// in the normal cones of both: no way along either surface leads nearer.
///
///         tool  \      /            the corner touches the face: n lies in both cones.  The edge
///                \    /             beside it, a seam in the same plane, does not: along its n'
///                the
///                 \  /              face beside it is nearer.  So n' bears nothing, though a
///              n'  \/               plane across it separates the two.
///                `. | n
///        -----------o----------     object
///              seam
///
/// The tolerances follow from what a tool at rest may be off by:
///  - kNear: the step keeps 1 um, and lets contacts up to 2 um hold; the third is for its next
///  step.
///  - kLean: a direction that is off by a milliradian is felt as a thousandth of the force, which
///    is what a step's rows are exact to.  A face that leans by less on a plane lies on it: it has
///    all its corners for contacts, as far as they are near.  That is 3 um over the face's size
///    where it is more than 3 mm, and never more than a milliradian where it is fine.
///  - kPlace: a pose that is off by 1 um is felt as 1 mN at 1 N/mm.  Over an edge or a corner that
///    turns the direction, at a distance of as little.  So those directions count that the same two
///    features have at a pose moved by so much, as far as they lie in both cones.
///  - kSame: places nearer than this are one.  Cones are found from all triangles at a place and
///    not from the mesh's indices, so that seams of coincident vertices, T-junctions (also in
///    files of floats: 7e-9 m at 0.1 m) and repeated triangles are no borders.
class ContactJudge {
 public:
  static constexpr double kNear = 3e-6;   ///< [m]
  static constexpr double kLean = 1e-3;   ///< [rad]
  static constexpr double kPlace = 1e-6;  ///< [m]
  static constexpr double kSame = 1e-8;   ///< [m]

  /// A mesh, or a ball if the radius is positive.  A ball is a ball also where the physics gives it
  /// smooth normals: there the angle between facets shows as force that is not borne.
  struct Tool {
    const TriangleMesh* mesh = nullptr;
    Vec3 center = Vec3::Zero();     ///< of a ball, in the tool's frame [m]
    double radius = 0.0;            ///< [m]
    Vec3 reference = Vec3::Zero();  ///< what wrenches are about, in the tool's frame [m]
  };
  struct Object {
    const TriangleMesh* mesh;
    Pose X_WB{};
    /// mu_s at a place in B; none: no friction.
    std::function<double(const Vec3& p_B)> static_friction{};
  };
  /// The meshes need not outlive this.
  ContactJudge(const Tool& tool, const std::vector<Object>& objects);
  /// For a scene's first tool and all its objects, with their friction if the scene has it: that of
  /// the nearest leaf.  The scene must outlive this.
  ContactJudge(const Scene& scene, const Vec3& reference);
  ~ContactJudge();

  /// Returns why scenes like this one are not judged, for people; empty if they are.  Out of scope
  /// are contact between leaves, the chapter's friction, and solids that burs cut.
  static std::string WhyNot(const Scene& scene);

  struct Contact {
    Vec3 at_W;        ///< on the tool [m]
    Vec3 normal_W;    ///< unit, from object to tool
    double distance;  ///< of the two features [m]
    double static_friction = 0.0;
  };
  /// Contacts, each once for each pair of features and each outermost direction.
  std::vector<Contact> ContactsAt(const Pose& X_WT) const;

  struct Verdict {
    double force = 0.0;   ///< what no contact bears [N]
    double torque = 0.0;  ///< [N m]
    std::size_t contacts = 0;
  };
  /// @param pull  on the tool, about its reference point, in W.
  /// @param length  turns torques into forces [m].  With the rotation length sqrt(k_r / k_t), what
  /// is left is the projected gradient of the spring's energy: over k_t, how far the tool would go.
  Verdict Judge(const Pose& X_WT, const Wrench& pull, double length) const;

 private:
  struct Part;
  struct NearPair;
  std::vector<NearPair> NearPairs(const Part& object, const Pose& X_WT) const;

  std::unique_ptr<const Part> tool_;
  double radius_ = 0.0;
  Vec3 reference_;
  std::vector<Part> objects_;
};

/// Returns the spring's wrench on the tool at X_WG, from its poses alone.
/// @param published  the step's wrench on the hand; says to which side a turn near half a turn
/// goes.
Wrench SpringPull(const Pose& X_WG, const Pose& X_WH, const Vec3& reference,
                  const Coupling& coupling, const Wrench& published);

}  // namespace palpate::test
