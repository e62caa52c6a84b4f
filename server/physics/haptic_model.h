#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/math/pose.h"
#include "scenes/effects/effects.h"
#include "scenes/sphere_tree.h"
#include "server/physics/contact_id.h"
#include "server/physics/cut/cutting.h"
#include "server/physics/step_types.h"
#include "server/physics/surface/block_bodies.h"
#include "server/physics/surface/contact_bodies.h"
#include "server/physics/surface/felt_solids.h"
#include "server/physics/tree/sphere_tree_query.h"

namespace palpate {

/// What the tools of a scene may touch: the objects' leaves as one tree, and the meshes of
/// the objects that are felt by their mesh.  Immutable; shared by the models of all tools.
class SceneObjects {
 public:
  /// Throws Error where there is no object, a tree is empty or not finite, or a mesh is lacking for
  /// ContactModel::kSurface.
  explicit SceneObjects(std::span<const PlacedTree> objects,
                        ContactModel contact = ContactModel::kSpheres,
                        std::vector<CutSolid> solids = {});

  /// The leaves of all objects; those of objects that are felt by their meshes touch nothing.
  const ObjectForest& forest() const { return forest_; }
  ContactModel contact() const { return contact_; }
  /// The objects that are felt by their meshes, and the boxes of what burs can cut, which contact
  /// looks into (surface/felt_solids.h); and a forest of the leaves of the former alone, null where
  /// there is none, which tells soonest what is deep inside (start_pose.h).
  std::span<const ContactBody> bodies() const { return bodies_; }
  std::span<const ContactBody> boxes() const { return bodies().last(boxes_); }
  const UncutBodies& uncut() const { return uncut_; }
  const ObjectForest* insides() const { return insides_ ? &*insides_ : nullptr; }
  /// What burs can cut.
  std::span<const CutSolid> solids() const { return solids_; }
  /// Of a solid, by its number there.
  const Material& MaterialOf(std::size_t solid, std::uint8_t material) const;

 private:
  ContactModel contact_;
  ObjectForest forest_;
  std::vector<ContactBody> bodies_;
  std::optional<ObjectForest> insides_;
  std::vector<CutSolid> solids_;
  std::size_t boxes_ = 0;
  UncutBodies uncut_;
  std::vector<std::vector<Material>> materials_;  ///< of each solid
};

/// What a step needs to know and never changes: one tool against the objects of a scene.
/// Built when a scene loads; shared by threads.
class HapticModel {
 public:
  /// `tool_mesh`: needed for ContactModel::kSurface only.  `cutting`: where the tool is a bur.
  /// `effects`: forces of one's own, which the step adds.
  /// Throws Error where a parameter is out of range, the tool's tree is empty or not finite, or its
  /// mesh is lacking.
  HapticModel(const SphereTree& tool, std::shared_ptr<const SceneObjects> objects,
              const StepParameters& parameters, const TriangleMesh* tool_mesh = nullptr,
              std::optional<Cutting> cutting = std::nullopt, Effects effects = {});

  const StepParameters& parameters() const { return parameters_; }  ///< derived values filled in
  const ToolTree& tool() const { return *tool_; }
  const ObjectForest& objects() const { return objects_->forest(); }
  /// Null where nothing is felt by its mesh.
  const ContactBody* tool_body() const { return tool_body_.get(); }
  std::span<const ContactBody> bodies() const { return objects_->bodies(); }
  std::span<const ContactBody> boxes() const { return objects_->boxes(); }
  const UncutBodies& uncut() const { return objects_->uncut(); }
  const ObjectForest* insides() const { return objects_->insides(); }
  /// Whether the features name compliance and some leaf is soft.
  bool yields() const { return parameters_.features.compliance && objects().yields(); }
  /// Null where the tool is no bur.
  const Cutting* cutting() const { return cutting_ ? &*cutting_ : nullptr; }
  const Effects& effects() const { return effects_; }
  /// What burs can cut, and whether the tool is one that may.
  std::span<const CutSolid> solids() const { return objects_->solids(); }
  bool cuts() const { return cutting_ && !solids().empty(); }
  /// Samples of the bur about the reference point, in the tool's frame.
  std::span<const BurSample> bur_samples() const { return bur_samples_; }
  double bur_lever() const { return bur_lever_; }  ///< of the farthest of them [m]
  /// What a row's contact is made of, and a leaf of the forest there; of a solid its object's
  /// first.
  const Material& MaterialOf(const ContactId& id, const FeltSolids& felt) const;
  std::int32_t LeafOf(const ContactId& id, const FeltSolids& felt) const;
  /// 3 where the tool is a single sphere (no contact can turn it), else 6.
  int degrees_of_freedom() const { return tool_->leaf_count() == 1 ? 3 : 6; }
  /// Point that the step and the wrench refer to, in the tool's frame [m]: the centroid.
  const Vec3& reference() const { return tool_->reference(); }
  /// Characteristic length sqrt(k_r / k_t) [m] that makes a rotation a length.
  double rotation_length() const { return rotation_length_; }

 private:
  void SetCutting();

  StepParameters parameters_;
  double rotation_length_ = 0.0;
  std::unique_ptr<const ToolTree> tool_;
  std::unique_ptr<const ContactBody> tool_body_;
  std::shared_ptr<const SceneObjects> objects_;
  std::optional<Cutting> cutting_;
  std::vector<BurSample> bur_samples_;
  double bur_lever_ = 0.0;
  Effects effects_;
};

}  // namespace palpate
