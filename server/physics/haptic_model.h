#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/math/pose.h"
#include "scenes/effects/effects.h"
#include "scenes/sphere_tree.h"
#include "server/physics/cut/cutting.h"
#include "server/physics/energy/inertia.h"
#include "server/physics/simd/kernels.h"
#include "server/physics/step_types.h"
#include "server/physics/surface/block_bodies.h"
#include "server/physics/surface/contact_bodies.h"
#include "server/physics/surface/solid_bodies.h"
#include "server/physics/tree/sphere_tree_query.h"

namespace palpate {

class HapticModel;
using FreeBodyModels = std::vector<std::unique_ptr<const HapticModel>>;

/// The objects that the tools of a scene can touch: the leaves of all objects as one tree, and
/// the meshes of those objects that are touched by their mesh.  Immutable; the models of all tools
/// share it.
struct SceneObjects {
  /// Throws Error if there is no object, if a tree is empty or not finite, if
  /// ContactModel::kSurface needs a mesh that an object lacks, or if a group has no object or no
  /// motion.
  explicit SceneObjects(std::span<const PlacedTree> objects,
                        ContactModel contact_model = ContactModel::kSpheres,
                        std::vector<CutSolid> cut_solids = {},
                        std::vector<MovedGroup> moved_groups = {});
  SceneObjects(const SceneObjects&) = delete;  // `uncut` refers to the others

  /// The boxes of the blocks of the solids that burs can cut (surface/solid_bodies.h): the last of
  /// the bodies.
  std::span<const ContactBody> boxes() const { return std::span(bodies).last(box_count); }

  ContactModel contact;
  /// The leaves of all objects.  Leaves of an object that is touched by its mesh touch nothing.
  ObjectForest forest;
  std::vector<ContactBody>
      bodies;  ///< the objects that are touched by their meshes, then the boxes
  std::size_t box_count = 0;
  /// The leaves of the former objects only, which show fastest what lies deep inside
  /// (start_pose.h); empty if there are none.
  std::optional<ObjectForest> insides;
  std::vector<CutSolid> solids;  ///< that burs can cut
  UncutBodies uncut;
  std::vector<MovedGroup> moved;  ///< group i is frame i + 1
  /// Of those groups that are free, in this order: the last members of a step (StepTogether).
  /// Null: there are none.
  std::shared_ptr<const FreeBodyModels> free_bodies{};
};

/// Everything that a step needs and never changes: one tool and the objects of a scene.  Built when
/// a scene loads; threads share it.
class HapticModel {
 public:
  /// `tool_mesh` is needed for ContactModel::kSurface only, `cutting` only if the tool is a bur or
  /// an edge.  The step adds the forces of `effects`.
  /// `inertia`: of a free body, which is a tool without a hand; its tree's centroid is its centre
  /// of mass, and its spring's stiffnesses are m / h^2 and rho^2 m / h^2 (RotationLengthOf). Throws
  /// Error if a parameter is out of range, if the tool's tree is empty or not finite, or if its
  /// mesh is needed and missing.
  HapticModel(const SphereTree& tool, std::shared_ptr<const SceneObjects> objects,
              const StepParameters& parameters, const TriangleMesh* tool_mesh = nullptr,
              std::optional<Cutting> cutting = std::nullopt, Effects effects = {},
              std::optional<Inertia> inertia = std::nullopt);

  /// With derived values filled in.
  const StepParameters& parameters() const { return parameters_; }
  const ToolTree& tool() const { return *tool_; }
  const ObjectForest& objects() const { return objects_->forest; }
  /// Null if nothing is touched by its mesh.
  const MovingBody* tool_body() const { return tool_body_.get(); }
  std::span<const ContactBody> bodies() const { return objects_->bodies; }
  std::span<const ContactBody> boxes() const { return objects_->boxes(); }
  std::span<const MovedGroup> moved() const { return objects_->moved; }
  /// The models of the scene's free bodies, which are stepped with the tool.
  std::span<const std::unique_ptr<const HapticModel>> free_bodies() const {
    using Models = std::span<const std::unique_ptr<const HapticModel>>;
    return objects_->free_bodies ? Models(*objects_->free_bodies) : Models();
  }
  const UncutBodies& uncut() const { return objects_->uncut; }
  const ObjectForest* insides() const { return objects_->insides ? &*objects_->insides : nullptr; }
  /// Returns whether compliance is among the features and some leaf is soft.
  bool yields() const { return parameters_.features.compliance && objects().yields; }
  /// Null if the tool cannot cut.
  const Cutting* cutting() const { return cutting_ ? &*cutting_ : nullptr; }
  const Effects& effects() const { return effects_; }
  /// Null if a hand holds the tool.
  const Inertia* inertia() const { return inertia_ ? &*inertia_ : nullptr; }
  /// The solids that burs can cut, and whether this tool may cut any of them.
  std::span<const CutSolid> solids() const { return objects_->solids; }
  bool cuts() const { return cutting_ && !solids().empty(); }
  /// The samples of the bur's surface, relative to the reference point, in the tool's frame.
  std::span<const BurSample> bur_samples() const { return bur_samples_; }
  /// The material that a row touches, and a leaf of the forest at that contact (for a solid: the
  /// first leaf of its object).
  const Material& MaterialOf(const ContactId& id, const SolidBodies& blocks) const;
  std::int32_t LeafOf(const ContactId& id, const SolidBodies& blocks) const;
  /// Returns whether the tool is a single sphere, which no contact can turn.
  bool is_ball() const { return tool_->leaves.size() == 1; }
  /// The point that the step and the wrench refer to, in the tool's frame [m]: the centroid.
  const Vec3& reference() const { return tool_->reference; }
  /// The characteristic length sqrt(k_r / k_t) [m], which converts a rotation to a length.
  double rotation_length() const { return rotation_length_; }

 private:
  void SetCutting();

  StepParameters parameters_;
  double rotation_length_ = 0.0;
  std::unique_ptr<const ToolTree> tool_;
  std::unique_ptr<const MovingBody> tool_body_;
  std::shared_ptr<const SceneObjects> objects_;
  std::optional<Cutting> cutting_;
  std::vector<BurSample> bur_samples_;
  Effects effects_;
  std::optional<Inertia> inertia_;
};

}  // namespace palpate
