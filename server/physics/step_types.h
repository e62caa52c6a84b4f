#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <span>

#include "common/math/pose.h"
#include "common/step_fault.h"
#include "common/step_tuning.h"
#include "scenes/scene.h"
#include "scenes/sphere_tree.h"
#include "server/physics/limits.h"
#include "server/physics/simd/kernels.h"

namespace palpate {

/// Most tools that are stepped together (StepTogether).
inline constexpr std::size_t kMostTools = kMostHands;

/// A body placed in the world.  The call that takes it does not keep its pointers.
struct PlacedTree {
  const SphereTree* tree = nullptr;
  Pose X_WB{};
  const TriangleMesh* mesh = nullptr;             ///< needed for ContactModel::kSurface only
  std::span<const std::uint8_t> leaf_material{};  ///< as in Body
  std::span<const Material> materials{};          ///< if empty, every leaf has Material{}
  bool is_cut = false;                            ///< touched as a CutSolid
  bool for_balls = false;  ///< a spherical tool will touch it: keeps its smooth normals
  /// Number of its frame (ContactBody): 0 for what burs cut.  For an object touched by its mesh.
  std::int32_t frame = 0;
  /// Number of the member that it is, in its own frame: of a step of several (StepTogether).  A
  /// tool has X_WB = I, a body the pose at which it is placed.  Negative: it is none.
  std::int32_t tool = -1;
  bool is_body = false;  ///< whether that member is a free body, and no hand's tool
};

/// Constants of the step that a scene or a benchmark may set; StepTuning holds those
/// that a researcher may vary, and limits.h derives them.
struct StepParameters : StepTuning {
  double stiffness = limits::kStiffness;                     ///< k_t [N/m]
  double torsional_stiffness = limits::kTorsionalStiffness;  ///< k_r [N m/rad]
  // Set by the HapticModel:
  double max_truncation = 0.0;  ///< kMaxTruncation of the contact (limits.h) [m]
  /// Largest bound on |phi| of one sub-step [rad]: sqrt(2 e / L) with e = max_truncation and L the
  /// tool's longest lever arm, so that linearising a rotation never errs by more than e.
  double max_rotation = 0.0;
  // Set by benchmarks and tests:
  int max_rows = limits::kMaxRows;
  Features features{.contact = ContactModel::kSpheres};
};

/// The largest motion of the graphic tool in one sub-step:
/// |v| <= translation [m], |phi| <= rotation [rad].
struct StepBounds {
  double translation;
  double rotation;
};

/// A row of the linearised non-penetration constraint (chapter 2.17) that carries force:
/// row . [v; phi] >= offset, with v of the tool's centroid, and phi, in W.  Not initialised: to
/// clear those of a report in each step takes a twentieth of it between leaves.
struct ActiveRow {
  ContactId id;
  /// Number of the other tool that it touches (StepTogether); negative: an object.  If the row is
  /// in that tool's model, `id` and `object_leaf` are, too.
  std::int32_t tool;
  std::int32_t object_leaf;  ///< index in the forest of the leaf that it touches
  const Material* material;  ///< of the touched object; valid as long as the model
  Vec3 normal;               ///< n, from object to tool, in W
  Vec3 lever_cross_normal;   ///< l x n [m], l from the centroid to the contact
  Vec3 contact_W;            ///< contact point on the tool, in W [m]
  double offset;             ///< -gap [m] at X_WG
  double force;              ///< multiplier >= 0 [N]
  /// Friction on the tool, in W [N].  With kCoulomb: perpendicular to the
  /// normal, at most mu * force.
  Vec3 friction;
  /// Stiffness of a soft contact [N/m]: force = stiffness * offset, and the row may be violated.
  /// Infinite if it is rigid.
  double stiffness;
};

/// Counters and measures of one step.
struct StepDiagnostics {
  int substeps = 0;
  int predicted_pairs = 0;      ///< number of rows in the last sub-step
  int qp_iterations = 0;        ///< over all sub-steps
  int friction_iterations = 0;  ///< Newton steps over all sub-steps
  int friction_yielded = 0;     ///< times that contacts yield by nanometres (friction.md)
  int friction_unsolved = 0;    ///< number of sub-steps whose friction did not converge
  int friction_resets = 0;      ///< consecutive steps reset by chapter 2.34, including this one
  double truncation = 0.0;      ///< largest bound on the linearisation error, 1/2 |phi|^2 lever [m]
};

/// The result of one step.  Force and torque act on the hand, at the tool's centroid, in W.
struct StepReport {
  Wrench wrench;
  EffectWrenches effects;  ///< the part of `wrench` that effects add
  Pose X_WG;
  /// The first `contacts` entries are set.  Rigid contacts come first (at most six, seven in a
  /// jam), then those soft contacts with the greatest force that fit.  A soft leaf entered to its
  /// rigid core has both.
  std::array<ActiveRow, 7> active;
  int contacts = 0;
  /// Number of soft contacts, listed or not.  A bur that material holds back counts as one
  /// and is not listed.
  int soft_contacts = 0;
  Wrench soft_wrench;  ///< sum of all soft contacts on the tool, at its centroid, in W
  /// Sum of the material's forces on the bur, in W [N], and the point at which viewers show it: the
  /// origin of the bur's frame, in W [m].
  Vec3 bur_force = Vec3::Zero(), bur_W = Vec3::Zero();
  std::uint32_t faults = kFaultNone;
  StepDiagnostics diagnostics;
  /// The parameters of this step; valid as long as the model.  Friction comes
  /// from each row's material.
  const StepParameters* parameters = nullptr;
};

/// Times of the step's stages, summed over sub-steps [ns], for benchmarks.
struct StageTimes {
  std::int64_t prediction = 0, rows = 0, solve = 0, response = 0;
};

/// Times the stages of a step for benchmarks.  Reads no clock if `times` is null.
class StageClock {
 public:
  explicit StageClock(StageTimes* times) : times_(times) {
    if (times_ != nullptr) last_ = std::chrono::steady_clock::now();
  }
  /// Adds the time since the last lap to a stage.
  void Lap(std::int64_t StageTimes::*stage) {
    if (times_ == nullptr) return;
    const auto now = std::chrono::steady_clock::now();
    times_->*stage += std::chrono::duration_cast<std::chrono::nanoseconds>(now - last_).count();
    last_ = now;
  }

 private:
  StageTimes* times_;
  std::chrono::steady_clock::time_point last_;
};

}  // namespace palpate
