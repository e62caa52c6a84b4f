#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "devices/simulated/simulated_phantom.h"
#include "scenes/scene.h"
#include "server/physics/haptic_step.h"

namespace palpate::bench {

/// The impedance of a hand that holds the handle, as published, or an estimate marked as such.
struct PublishedHand {
  std::string name;
  std::string source;
  HandImpedance impedance;
};
const std::vector<PublishedHand>& PublishedHands();
/// Returns a hand by its name; throws UsageError, which lists the valid names.
const PublishedHand& PublishedHandOf(const std::string& name);

/// A closed loop of an arm and hand, a link and a server.
struct ClosedLoopCase {
  std::string arm = "premium-3.0";  ///< PhantomSheetOf
  std::string hand = "van-beek";
  double delay_ms = 0.0;   ///< round trip; half of it each way
  double jitter_ms = 0.0;  ///< additional round-trip delay, from 0 to this
  double loss = 0.0;       ///< share of the samples lost in each direction
  bool local_model = true;
  bool passivity = true;  ///< the limiter's energy stage
  /// Stiffness of the coupling; the torsional one is the scene's, in proportion.
  double stiffness_N_per_m = 1000.0;
  std::uint64_t seed = 1;  ///< random seed of the link
};

/// The scene of the loop: what the hand touches, and how.
struct ClosedLoopScene {
  std::string name;
  Scene scene;
  std::shared_ptr<const SceneObjects> objects;
  Pose above;            ///< start pose of the hand, free of contact
  Pose touching;         ///< pose in which the tool touches
  Vec3 normal;           ///< outward normal of the touched surface
  double press_N = 2.0;  ///< force with which the hand presses
};
/// Makes a scene.  "wall": a ball of 5 mm on a plate.  "bunny": bunny-bunny, pressed on the back.
ClosedLoopScene MakeClosedLoopScene(const std::string& name);

/// What the hand felt.  The hand comes down, presses, reduces its pressure by half and presses
/// again in one step, tries to hold still for kClosedLoopWatch_s, and leaves.  Then the contact has
/// given back its stored energy, and any surplus was generated.
struct ClosedLoopFigures {
  bool stable = false;
  double limit_cycle_mm = 0.0;   ///< handle's motion, peak to peak, in the last kClosedLoopCycle_s
  double limit_cycle_deg = 0.0;  ///< its rotation likewise; both while the hand tries to hold still
  double energy_J = 0.0;         ///< greatest surplus of energy that the device gave the hand
  double energy_end_J = 0.0;     ///< the value at the end; negative: taken from the hand
  /// energy_J computed from the encoders, which is all that a passivity controller sees; the true
  /// value may be larger by a force times an encoder step.
  double energy_seen_J = 0.0;
  double mean_force_N = 0.0;   ///< applied, in the last kClosedLoopCycle_s
  double rendered = 0.0;       ///< share of the force that the station requests from its limiter
  double beyond_region = 0.0;  ///< share of the ticks
};
inline constexpr double kClosedLoopPress_s = 1.5;
inline constexpr double kClosedLoopTap_s = 0.1;
inline constexpr double kClosedLoopWatch_s = 3.0;
inline constexpr double kClosedLoopCycle_s = 1.0;
inline constexpr double kClosedLoopLift_s = 0.5;

/// A loop is stable if it comes to rest by itself: in the last kClosedLoopCycle_s there is a force
/// on the handle all the time, and it moves and rotates by at most two encoder steps, the least
/// that encoders distinguish from rest.
/// Virtual time: equal arguments, equal bits.
ClosedLoopFigures RunClosedLoop(const ClosedLoopScene& scene, const ClosedLoopCase& c);

/// The greatest stiffness for one configuration of the loop.
struct ZWidth {
  double stiffness_N_per_m = 0.0;  ///< of the coupling, up to which RunClosedLoop is stable
  /// Greatest stiffness up to there that the hand feels after the limiter's reduction: stiffness
  /// times ClosedLoopFigures::rendered.
  double felt_N_per_m = 0.0;
};
/// Finds it within 2 %; kStiffest if all are stable.
inline constexpr double kLeastStiffness = 10.0;  ///< [N/m]
inline constexpr double kStiffest = 100'000.0;
ZWidth MeasureZWidth(const ClosedLoopScene& scene, ClosedLoopCase c);

}  // namespace palpate::bench
