#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/math/pose.h"
#include "scenes/scene.h"
#include "server/physics/haptic_step.h"
#include "tests/support/force_shape.h"
#include "tests/support/jump_cause.h"
#include "tests/support/support_figures.h"

namespace palpate::test {

/// A tool and the hand that drives it.
struct ContactPath {
  const Scene& scene;  ///< its first tool is driven
  const HapticModel& model;
  StepWorkspace& workspace;
  const StepState& start;
  std::span<const Pose> X_WH;  ///< one pose per millisecond
};

/// What to measure, and at which steps: every n-th; 0 means never.
struct ContactChecks {
  int oracle_every = 1;
  int converge_every = 1;
  int settle_every = 0;
  int judge_every = 0;         ///< with ContactJudge
  bool hold_far = false;       ///< checks after each step that did not arrive whether later ones do
  bool quarter_steps = false;  ///< repeats the path at 4 kHz
  /// Called with the present activity and the share done.
  std::function<void(std::string_view what, double share)> progress = {};
};

/// Measured properties of contact that do not depend on the contact model.  MeshOracle judges the
/// poses; the converged step itself is the reference for the forces.
struct ContactFigures {
  std::size_t steps = 0;
  bool finite = true;       ///< all poses and wrenches
  double mean_speed = 0.0;  ///< of the tool's centroid in the hand [m/s]

  std::vector<double> depth;  ///< penetration of the meshes at X_WG [m], at each step checked
  std::size_t meeting = 0;    ///< number of those steps at which the meshes have a common point
  std::size_t deepest_step = 0;
  double meeting_fraction() const;

  std::size_t arrived = 0;  ///< steps without kFaultTargetFar
  double arrived_fraction() const;
  std::size_t longest_behind = 0;  ///< greatest number of successive steps that did not arrive
  static constexpr int kHeldSteps = 200;
  static constexpr std::size_t kMostHeld = 500;
  /// Results of continuing from steps that did not arrive, with the hand held still for kHeldSteps
  /// more.  Of more than kMostHeld such steps only every second (fourth, ...) is tried, so that at
  /// least half of kMostHeld are.
  struct Held {
    std::size_t tried = 0;
    std::size_t never = 0;          ///< did not arrive in any further step
    std::size_t without_force = 0;  ///< number of those whose force ends below 1 mN
    /// Number of those whose last two poses are equal bit for bit: they never give a force.
    std::size_t stuck = 0;
    std::size_t first_step = 0;     ///< the first of those that never arrive
    std::vector<int> steps_needed;  ///< by those that arrived, sorted
    /// |F - F_arrived| [N] of those that arrived, sorted: the force that was felt late.
    std::vector<double> force_error;
    int median() const { return steps_needed.empty() ? 0 : steps_needed[steps_needed.size() / 2]; }
  };
  Held held;

  /// Differences from the converged answer, which is found by repeating the step with the same hand
  /// until no point of the tool moves by 1e-8 m in a step that arrives, in at most 200 steps.
  std::vector<double> lag;            ///< of centroids, at steps that did not arrive [m]
  std::vector<double> force_error;    ///< |F - F_converged| at all steps checked [N]
  std::vector<double> arrived_error;  ///< the same at the steps that arrived [N]
  std::size_t unconverged = 0;        ///< still moving after the 200, or still not arrived

  struct Jumps {
    double torque_max = 0.0;                       ///< [N m]; of the force: ForceShape
    std::array<std::size_t, kJumpCauses> count{};  ///< number of jumps above kJump, by cause
    std::array<double, kJumpCauses> force{};       ///< greatest of each cause [N]
    std::array<std::size_t, kJumpCauses> step{};   ///< where that was
    std::size_t behind = 0;  ///< jumps except kHand before or after which the tool had not arrived
    std::size_t unexplained() const { return count[static_cast<int>(JumpCause::kUnexplained)]; }
  };
  Jumps jumps;

  SupportFigures support;  ///< its counts of friction are always filled in

  /// Notches, ledges and passing changes, judged from the forces alone.
  ForceShape force;

  /// Results of stopping the hand at each step checked, for 2,000 further steps.  The tool has
  /// settled once it has arrived and no point of it moves by more than 1 nm per step any more.
  struct Settling {
    std::size_t poses = 0, within_10ms = 0, within_50ms = 0, never = 0;
    double cycle_m = 0.0, cycle_N = 0.0;  ///< greatest change of the tool, the force, after 1 s
    std::size_t worst_step = 0;           ///< where that was
  };
  Settling settling;

  /// RMS of the difference between the forces of a hand sampled at 1 kHz and at 4 kHz (the same
  /// path, straight between its samples), at their common times, over the RMS of the force.
  double force_4khz_rms_fraction = 0.0;
  double force_rms = 0.0;  ///< [N]
};

/// @param reports  filled in if given.
ContactFigures MeasureContact(const ContactPath& path, const ContactChecks& checks,
                              std::vector<StepReport>* reports = nullptr);
/// The same for a scene: makes its model, and starts the tool at the resolved first pose.
ContactFigures MeasureContact(const Scene& scene, std::span<const Pose> X_WH,
                              const ContactChecks& checks,
                              std::vector<StepReport>* reports = nullptr);

/// Limits that a contact model must keep; the defaults accept anything finite.
struct ContactLimits {
  double meeting_fraction = 1.0;                           ///< at most
  double depth = std::numeric_limits<double>::infinity();  ///< [m], at most
  double arrived_fraction = 0.0;                           ///< at least
  std::size_t never_arrived = std::numeric_limits<std::size_t>::max();
  std::size_t stuck = std::numeric_limits<std::size_t>::max();
  std::size_t notches = std::numeric_limits<std::size_t>::max();
  double jump = std::numeric_limits<double>::infinity();  ///< [N], of any cause, at most
  std::size_t unexplained = std::numeric_limits<std::size_t>::max();
  double force_4khz = std::numeric_limits<double>::infinity();  ///< rms fraction, at most
  double settled_10ms = 0.0, settled_50ms = 0.0;                ///< shares, at least
};
/// Returns the broken limits, one line each, with the step where it happens; empty if all hold.
std::string BrokenLimits(const ContactFigures& figures, const ContactLimits& limits);

}  // namespace palpate::test
