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

namespace palpate::test {

/// A tool and the hand that drives it.
struct ContactPath {
  const Scene& scene;  ///< its first tool is driven
  const HapticModel& model;
  StepWorkspace& workspace;
  const StepState& start;
  std::span<const Pose> X_WH;  ///< a row a millisecond
};

/// What is measured, and at which steps: every n-th; 0 is never.
struct ContactChecks {
  int oracle_every = 1;
  int converge_every = 1;
  int settle_every = 0;
  bool hold_far = false;       ///< of each step that did not arrive, whether the next ones do
  bool quarter_steps = false;  ///< the path again at 4 kHz
  /// Told what is being done and which share is done.
  std::function<void(std::string_view what, double share)> progress = {};
};

/// What holds of contact whatever model makes it.  Poses are judged by MeshOracle, forces by the
/// step itself where it has had the time to end.
struct ContactFigures {
  std::size_t steps = 0;
  bool finite = true;       ///< all poses and wrenches
  double mean_speed = 0.0;  ///< of the tool's centroid in the hand [m/s]

  std::vector<double> depth;  ///< of the meshes in each other at X_WG [m], of each step looked at
  std::size_t meeting = 0;    ///< of those: the meshes have a point in common
  std::size_t deepest_step = 0;
  double meeting_fraction() const;

  std::size_t arrived = 0;  ///< steps without kFaultTargetFar
  double arrived_fraction() const;
  std::size_t longest_behind = 0;  ///< most steps in a row that did not arrive
  static constexpr int kHeldSteps = 200;
  static constexpr std::size_t kMostHeld = 500;
  /// Steps that did not arrive, gone on from with the hand held still for kHeldSteps more.  Of more
  /// than kMostHeld every second is tried, or every fourth and so on: at least half as many.
  struct Held {
    std::size_t tried = 0;
    std::size_t never = 0;          ///< arrive in none of the steps more
    std::size_t without_force = 0;  ///< of those: the force ends below 1 mN
    /// Of those: the last two poses are the same bits, so that a hand may press for ever and feel
    /// nothing.
    std::size_t stuck = 0;
    std::size_t first_step = 0;     ///< the first of those that never arrive
    std::vector<int> steps_needed;  ///< by the others, sorted
    /// |F - F_arrived| [N] of the others, sorted: what they felt late.
    std::vector<double> force_error;
    int median() const { return steps_needed.empty() ? 0 : steps_needed[steps_needed.size() / 2]; }
  };
  Held held;

  /// Against the converged answer: the step's state stepped on with the same hand, until no point
  /// of the tool moves by 1e-8 m in a step that arrives, 200 steps at most.
  std::vector<double> lag;            ///< of centroids, at steps that did not arrive [m]
  std::vector<double> force_error;    ///< |F - F_converged| at all steps looked at [N]
  std::vector<double> arrived_error;  ///< of those, at the steps that arrived [N]
  std::size_t unconverged = 0;        ///< still moving after the 200, or still not arrived

  struct Jumps {
    double torque_max = 0.0;                       ///< [N m]; of the force: ForceShape
    std::array<std::size_t, kJumpCauses> count{};  ///< by cause, of those above kJump
    std::array<double, kJumpCauses> force{};       ///< greatest of each cause [N]
    std::array<std::size_t, kJumpCauses> step{};   ///< where that was
    std::size_t behind = 0;  ///< of those but kHand: the tool had not arrived before or after it
    std::size_t unexplained() const { return count[static_cast<int>(JumpCause::kUnexplained)]; }
  };
  Jumps jumps;

  /// Notches, ledges and changes that pass, by the forces alone.
  ForceShape force;

  /// The hand stops: 2,000 further steps with the same pose, of each step looked at.  Settled is
  /// from when on no point of the tool moves by more than 1 nm in a step, and the tool has arrived.
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

/// @param reports  filled where given.
ContactFigures MeasureContact(const ContactPath& path, const ContactChecks& checks,
                              std::vector<StepReport>* reports = nullptr);
/// The same of a scene alone: makes its model, and starts the tool at the first pose, or out of
/// what that is in.
ContactFigures MeasureContact(const Scene& scene, std::span<const Pose> X_WH,
                              const ContactChecks& checks,
                              std::vector<StepReport>* reports = nullptr);

/// What a model of contact must hold; the defaults let anything pass but what is not finite.
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
/// What does not hold, a line each, with the step where it is seen; empty where all does.
std::string BrokenLimits(const ContactFigures& figures, const ContactLimits& limits);

}  // namespace palpate::test
