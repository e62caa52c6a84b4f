#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>

#include "common/math/pose.h"
#include "common/step_fault.h"
#include "scenes/scene.h"
#include "scenes/sphere_tree.h"
#include "server/physics/leaf_wear.h"
#include "server/physics/simd/kernels.h"

namespace palpate {

/// A body placed in the world.  What it points to must outlive the call that takes it, no longer.
struct PlacedTree {
  const SphereTree* tree = nullptr;
  Pose X_WB{};
  const TriangleMesh* mesh = nullptr;             ///< needed for ContactModel::kSurface only
  std::span<const std::uint8_t> leaf_material{};  ///< as in Body
  std::span<const Material> materials{};          ///< empty: all leaves are of Material{}
};

/// Constants of the step.  Zero means "derived", by the rule in the comment.
struct StepParameters {
  double stiffness = 1000.0;         ///< k_t [N/m], chapter 2.3
  double torsional_stiffness = 1.0;  ///< k_r [N m/rad]
  /// Greatest bound on |v| of one sub-step [m]: the chapter's 0.5 m/s for 1 ms.
  double max_translation = 0.5e-3;
  /// Greatest bound on |phi| of one sub-step [rad].  0: sqrt(2 e / L) with e = max_truncation and L
  /// the tool's longest lever arm, so that linearising a rotation is never off by more than e.
  double max_rotation = 0.0;
  double max_truncation = 0.5e-6;  ///< [m]
  int max_substeps = 8;            ///< per cycle; a count, never a clock
  int max_rows = 16384;
  /// A further sub-step is begun where one like the last would leave the cycle's packet pairs and
  /// candidates, which take some 10 ns each, below this: what a snap over a ledge costs at most,
  /// and the next cycle goes on.  A count, never a clock.
  int max_tested = 5000;
  Features features{.contact = ContactModel::kSpheres};
};

class ObjectForest;  // the scene's objects, in W, as one tree: sphere_tree_query.h
class ToolTree;      // the tool's tree, about its centroid
class ToolSurface;   // the tool's surface: surface_prediction.h
class SoftLeaves;    // what finite stiffness means to the step: soft_rows.h

/// What a step needs to know and never changes: one tool against the objects of a scene.
/// Built when a scene loads; shared by threads.
class HapticModel {
 public:
  /// Throws Error where a tree is empty or not finite, or a mesh is lacking for surface contact.
  static std::shared_ptr<const ObjectForest> MakeObjects(
      std::span<const PlacedTree> objects, ContactModel contact = ContactModel::kSpheres);
  /// `tool_mesh`: needed for ContactModel::kSurface only.
  HapticModel(const SphereTree& tool, std::shared_ptr<const ObjectForest> objects,
              const StepParameters& parameters, const TriangleMesh* tool_mesh = nullptr);
  ~HapticModel();
  HapticModel(HapticModel&&) noexcept;

  const StepParameters& parameters() const { return parameters_; }  ///< derived values filled in
  const ToolTree& tool() const { return *tool_; }
  const ObjectForest& objects() const { return *objects_; }
  /// Null with ContactModel::kSpheres.
  const ToolSurface* tool_surface() const { return tool_surface_.get(); }
  /// Null unless the features name compliance and some leaf is soft.
  const SoftLeaves* soft_leaves() const { return soft_.get(); }
  /// 3 where the tool is a single sphere (no contact can turn it), else 6.
  int degrees_of_freedom() const;
  /// Point that the step and the wrench refer to, in the tool's frame [m]: the centroid.
  const Vec3& reference() const;
  /// Characteristic length sqrt(k_r / k_t) [m] that makes a rotation a length.
  double rotation_length() const { return rotation_length_; }

 private:
  StepParameters parameters_;
  double rotation_length_ = 0.0;
  std::unique_ptr<const ToolTree> tool_;
  std::unique_ptr<const ToolSurface> tool_surface_;
  std::shared_ptr<const ObjectForest> objects_;
  std::unique_ptr<const SoftLeaves> soft_;
};

/// What friction remembers from step to step.
struct FrictionState {
  /// Cycles since a contact last slipped, up to kStillCycles (friction.h), where mu_s holds.  A
  /// tool that comes to a surface has not slipped.
  int still = 1 << 20;
  int resets = 0;          ///< FrictionModel::kChapter: consecutive steps that 2.34 has reset
  bool suspended = false;  ///< no friction: for the walk to a start pose
  // The forces that the solver starts from, in metres (times k_t: newtons): coulomb.
  int contacts = 0;
  std::array<LeafPair, 7> pair;
  std::array<double, 7> normal_force;
  std::array<Vec3, 7> force;  ///< in W
};

/// How far one sub-step may take the graphic tool: |v| <= translation [m], |phi| <= rotation [rad].
struct StepBounds {
  double translation;
  double rotation;
};

/// What one step hands to the next: all the memory that the physics has.  Copying it and stepping
/// again with the same pose gives the same bits.
struct StepState {
  StepState() = default;
  /// Allocates where the model's features name removal: objects are whole.  A state made without
  /// its model wears nothing.
  explicit StepState(const HapticModel& model);

  Pose X_WG;                             ///< graphic tool
  Pose X_WH;                             ///< haptic tool: how far the hand moved sets the bounds
  std::array<LeafPair, 7> active_pairs;  ///< rows that held it last, the solver's first guess
  int active = 0;
  /// Surface contact: bounds of the next sub-step where the last cycle ended before the tool had
  /// arrived; else 0.
  StepBounds behind{0.0, 0.0};
  FrictionState friction;
  LeafWear wear;
};

/// A row of the linearised non-penetration constraint (chapter 2.17) that carries force:
/// row . [v; phi] >= offset, v of the tool's centroid and phi in W.
struct ActiveRow {
  LeafPair pair;
  std::int32_t object_leaf = -1;           ///< of the forest: whose material counts
  Vec3 normal = Vec3::Zero();              ///< n, from object to tool, in W
  Vec3 lever_cross_normal = Vec3::Zero();  ///< l x n [m], l from the centroid to the contact
  Vec3 contact_W = Vec3::Zero();           ///< contact point on the tool, in W [m]
  double offset = 0.0;                     ///< -gap [m] at X_WG
  double force = 0.0;                      ///< multiplier >= 0 [N]
  /// On the tool, in W [N]; kCoulomb: perpendicular to the normal, at most mu * force.
  Vec3 friction = Vec3::Zero();
  /// Of a soft contact [N/m]: force = stiffness * offset, and the row may be violated.
  double stiffness = std::numeric_limits<double>::infinity();
};

/// Result of one step.  force and torque act on the hand, at the tool's centroid, in W.
struct StepReport {
  Wrench wrench;
  Pose X_WG;
  /// The first `contacts` are set: rigid ones, at most six, seven in a jam; then soft ones, as many
  /// as fit, those of the greatest force.  A soft leaf entered to its rigid core is both.
  std::array<ActiveRow, 7> active;
  int contacts = 0;
  int soft_contacts = 0;  ///< all of them, listed or not
  Wrench soft_wrench;     ///< sum of all soft contacts on the tool, at its centroid, in W
  /// Object leaves that vanish with this step, in the order of their contacts.
  std::array<std::int32_t, 7> removed;
  int removals = 0;
  std::uint32_t faults = kFaultNone;
  // Counters and measures of this step.
  int substeps = 0;
  int predicted_pairs = 0;      ///< rows of the last sub-step
  int qp_iterations = 0;        ///< of all sub-steps
  int friction_iterations = 0;  ///< Newton steps, of all sub-steps
  int friction_lowered = 0;     ///< times that friction took lower limits than Coulomb's
  int friction_unsolved = 0;    ///< sub-steps whose friction did not converge
  int friction_resets = 0;      ///< chapter 2.34: consecutive steps reset, this one included
  double truncation = 0.0;      ///< bound on the linearisation error, 1/2 |phi|^2 lever [m], worst
};

/// Times of the step's stages, for benchmarks: [ns], summed over sub-steps.
struct StageTimes {
  std::int64_t prediction = 0, rows = 0, solve = 0, response = 0;
};

/// Buffers that a step needs, allocated once.  One per thread that steps, of any number of tools of
/// one model; holds no state from step to step.
class StepWorkspace {
 public:
  explicit StepWorkspace(const HapticModel& model);
  ~StepWorkspace();
  StepWorkspace(StepWorkspace&&) noexcept;
  struct Buffers;
  Buffers& buffers() { return *buffers_; }

 private:
  std::unique_ptr<Buffers> buffers_;
};

/// The haptic step, once per millisecond and tool: finds the pose of the graphic tool nearest to
/// the haptic tool's without entering an object, and the wrench of the spring between the two.
/// Chapter 2.3 and 2.4; ARCHITECTURE.md says where the project departs from it.
/// @param X_WH  haptic tool, of the tool tree's frame.  Non-finite poses set kFaultBadPose.
/// @param times null in the servo loop; where given, the stages are timed (the result is the same).
/// Real-time: no allocation, lock, log; a clock only where `times` is given.
/// Deterministic: equal inputs, equal bits, whatever the build type, SIMD level or thread.
StepReport HapticStep(const HapticModel& model, const Pose& X_WH, StepState& state,
                      StepWorkspace& workspace, StageTimes* times = nullptr) noexcept;

/// Where the graphic tool may start for a haptic pose: at X_WH itself if that is free, else at a
/// free pose near it.
/// @field depth  distance from X_WH to X_WG [m]; 0 where X_WH is free.
struct StartPose {
  Pose X_WG;
  double depth = 0.0;
};

/// Resolves a start in penetration.  Not real-time (milliseconds): called before forces begin.
/// @param wear  what has gone; null: nothing has.
StartPose ResolveStart(const HapticModel& model, const Pose& X_WH, StepWorkspace& workspace,
                       const LeafWear* wear = nullptr);

}  // namespace palpate
