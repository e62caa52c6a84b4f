#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "common/math/pose.h"
#include "scenes/scene.h"
#include "server/physics/haptic_step.h"
#include "tests/support/contact_judge.h"

namespace palpate::test {

/// Whether contacts bear the tool where it has arrived, by ContactJudge, and whether it would stay.
struct SupportFigures {
  std::string not_judged_for{};       ///< ContactJudge::WhyNot; if not empty, nothing was judged
  std::vector<double> force, torque;  ///< what no contact bears, of each cycle judged [N, N m]
  std::size_t worst_step = 0;         ///< where the force of these is greatest
  std::size_t soft = 0;  ///< cycles not judged, because something yields or leaves touch

  /// Places at which the hand, held still, was moved by kNudge and kNudgeTurn and back, in a
  /// direction that depends on the step's number.  A tool is freed if within kHeldAfter cycles more
  /// than kFreed of the spring's energy is lost, and more than its pull does over
  /// ContactJudge::kNear, by which contacts may differ.
  std::size_t nudged = 0, freed = 0;
  std::size_t freed_unnudged = 0;  ///< of `freed`: those that lose as much if only held
  /// Of `freed`: those that lose as much without a nudge if friction is dynamic.  So static
  /// friction alone held them, a true barrier, which any slip breaks.
  std::size_t freed_of_stiction = 0;
  std::size_t first_freed = 0;                               ///< step of the first
  static constexpr double kNudge = 3e-6, kNudgeTurn = 3e-4;  ///< [m], [rad]
  static constexpr int kHeldAfter = 60;
  static constexpr double kFreed = 0.01;

  // Of all cycles, judged or not:
  std::size_t friction_unsolved = 0, friction_yielded = 0;
};

/// Collects SupportFigures of a path.
class SupportMeasure {
 public:
  /// All must outlive this.
  SupportMeasure(const Scene& scene, const HapticModel& model, StepWorkspace& workspace);

  /// Counts a cycle's friction.
  void Count(const StepReport& report);
  /// Judges a cycle, if it has arrived.  `state`: after it.
  void Judge(std::size_t step, const Pose& X_WH, const StepReport& report, const StepState& state);
  const SupportFigures& figures() const { return figures_; }

 private:
  Wrench PullAt(const Pose& X_WG, const Pose& X_WH, const Wrench& published) const;
  double EnergyOf(const Wrench& pull) const;
  double EnergyAfter(const Pose& X_WH, const Pose& nudged, StepState state) const;

  const Scene& scene_;
  const HapticModel& model_;
  StepWorkspace& workspace_;
  ContactJudge judge_;
  double length_;  ///< sqrt(k_r / k_t) [m]
  SupportFigures figures_;
};

}  // namespace palpate::test
