#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "devices/simulated/simulated_phantom.h"
#include "scenes/scene.h"
#include "server/physics/haptic_step.h"

namespace palpate::bench {

/// A hand that holds the handle, as somebody has measured it, or an estimate called one.
struct PublishedHand {
  std::string name;
  std::string source;
  HandImpedance impedance;
};
const std::vector<PublishedHand>& PublishedHands();
/// Throws UsageError that names those that there are.
const PublishedHand& PublishedHandOf(const std::string& name);

/// An arm and hand, a link and a server, closed to a loop.
struct ClosedLoopCase {
  std::string arm = "premium-3.0";  ///< PhantomSheetOf
  std::string hand = "van-beek";
  double delay_ms = 0.0;   ///< there and back; half of it each way
  double jitter_ms = 0.0;  ///< further delay, from 0 to this there and back
  double loss = 0.0;       ///< of the samples of each way
  bool local_model = true;
  bool passivity = true;  ///< the limiter's energy stage
  /// Of the coupling; its torsional one is the scene's, in proportion.
  double stiffness_N_per_m = 1000.0;
  std::uint64_t seed = 1;  ///< of the link
};

/// Where it happens: what the hand touches, and how.
struct ClosedLoopScene {
  std::string name;
  Scene scene;
  std::shared_ptr<const SceneObjects> objects;
  Pose above;            ///< the hand begins here, free
  Pose touching;         ///< the tool touches here
  Vec3 normal;           ///< out of what it touches
  double press_N = 2.0;  ///< what the hand presses with
};
/// "wall": a ball of 5 mm on a plate.  "bunny": bunny-bunny, pressed on the back.
ClosedLoopScene MakeClosedLoopScene(const std::string& name);

/// What the hand felt.  The hand comes down, presses, lets go by half and presses again in one
/// step, means to hold still for kClosedLoopWatch_s, and goes, so that what the contact stores is
/// given back and what is left over was generated.
struct ClosedLoopFigures {
  bool stable = false;
  double limit_cycle_mm = 0.0;  ///< way of the handle, peak to peak, in the last kClosedLoopCycle_s
  double limit_cycle_deg = 0.0;  ///< its rotation likewise; both while it means to hold still
  double energy_J = 0.0;         ///< most that the device ever gave the hand beyond what it had got
  double energy_end_J = 0.0;  ///< that at the end, with its sign: negative was taken from the hand
  /// energy_J by the encoders' way, which is all that a passivity controller sees: the truth may be
  /// more by a force over an encoder's step.
  double energy_seen_J = 0.0;
  double mean_force_N = 0.0;  ///< applied, in the last kClosedLoopCycle_s
  double rendered = 0.0;  ///< of the force that the station then asks its limiter for, the share
  double beyond_region = 0.0;  ///< share of the ticks
};
inline constexpr double kClosedLoopPress_s = 1.5;
inline constexpr double kClosedLoopTap_s = 0.1;
inline constexpr double kClosedLoopWatch_s = 3.0;
inline constexpr double kClosedLoopCycle_s = 1.0;
inline constexpr double kClosedLoopLift_s = 0.5;

/// Stable is a loop that comes to rest by itself: in the last kClosedLoopCycle_s the handle is
/// pushed all the time, and moves and turns by no more than two steps of its encoders, which is as
/// little as they tell from rest.
/// Virtual time: equal arguments, equal bits.
ClosedLoopFigures RunClosedLoop(const ClosedLoopScene& scene, const ClosedLoopCase& c);

/// How stiff it may be, one way of closing the loop.
struct ZWidth {
  double stiffness_N_per_m =
      0.0;  ///< the greatest of the coupling up to which RunClosedLoop is stable
  /// Up to there the most that the hand is held by, once the limiter has held back what it must:
  /// stiffness times ClosedLoopFigures::rendered.
  double felt_N_per_m = 0.0;
};
/// To 2 %; kStiffest where all are stable.
inline constexpr double kLeastStiffness = 10.0;  ///< [N/m]
inline constexpr double kStiffest = 100'000.0;
ZWidth MeasureZWidth(const ClosedLoopScene& scene, ClosedLoopCase c);

}  // namespace palpate::bench
