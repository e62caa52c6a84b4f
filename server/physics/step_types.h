#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "common/math/pose.h"
#include "common/step_fault.h"
#include "common/step_tuning.h"
#include "scenes/scene.h"
#include "scenes/sphere_tree.h"
#include "server/physics/contact_id.h"
#include "server/physics/limits.h"

namespace palpate {

/// A body placed in the world.  What it points to must outlive the call that takes it, no longer.
struct PlacedTree {
  const SphereTree* tree = nullptr;
  Pose X_WB{};
  const TriangleMesh* mesh = nullptr;             ///< needed for ContactModel::kSurface only
  std::span<const std::uint8_t> leaf_material{};  ///< as in Body
  std::span<const Material> materials{};          ///< empty: all leaves are of Material{}
  bool is_cut = false;                            ///< felt as a CutSolid
};

/// Constants of the step that a scene or a benchmark may set (StepTuning has those that a
/// researcher may vary); limits.h derives them.  Zero means "derived", by the rule in the comment.
struct StepParameters : StepTuning {
  double stiffness = limits::kStiffness;                     ///< k_t [N/m]
  double torsional_stiffness = limits::kTorsionalStiffness;  ///< k_r [N m/rad]
  /// Greatest bound on |phi| of one sub-step [rad].  0: sqrt(2 e / L) with e = max_truncation and L
  /// the tool's longest lever arm, so that linearising a rotation is never off by more than e.
  double max_rotation = 0.0;
  double max_truncation = 0.0;  ///< [m]; 0: kMaxTruncation of the contact (limits.h)
  int max_rows = limits::kMaxRows;
  Features features{.contact = ContactModel::kSpheres};
};

/// How far one sub-step may take the graphic tool: |v| <= translation [m], |phi| <= rotation [rad].
struct StepBounds {
  double translation;
  double rotation;
};

/// A row of the linearised non-penetration constraint (chapter 2.17) that carries force:
/// row . [v; phi] >= offset, v of the tool's centroid and phi in W.
struct ActiveRow {
  ContactId id;
  std::int32_t object_leaf = -1;           ///< of the forest: what it belongs to
  const Material* material = nullptr;      ///< of what it touches, as long as the model lives
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
  EffectWrenches effects;  ///< what of it forces of one's own are
  Pose X_WG;
  /// The first `contacts` are set: rigid ones, at most six, seven in a jam; then soft ones, as many
  /// as fit, those of the greatest force.  A soft leaf entered to its rigid core is both.
  std::array<ActiveRow, 7> active;
  int contacts = 0;
  /// All of them, listed or not.  A bur that material holds back is one, and is not listed.
  int soft_contacts = 0;
  Wrench soft_wrench;  ///< sum of all soft contacts on the tool, at its centroid, in W
  /// Of all material on the bur, in W [N], and where that is shown: at the bur's frame, in W.
  Vec3 bur_force = Vec3::Zero(), bur_W = Vec3::Zero();
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
  /// What the step was made with, as long as the model lives; friction is of each row's material.
  const StepParameters* parameters = nullptr;
};

/// Times of the step's stages, for benchmarks: [ns], summed over sub-steps.
struct StageTimes {
  std::int64_t prediction = 0, rows = 0, solve = 0, response = 0;
};

}  // namespace palpate
