#pragma once

#include "common/math/pose.h"
#include "scenes/scene.h"
#include "tests/benchmarks/peers/peer.h"

namespace palpate::bench {

/// The spring and damper between a peer's tool and the hand (Colgate, Stanley & Brown, IROS 1995),
/// the same for all peers: 6 degrees of freedom, critically damped.
///
/// The tool is a body of 0.1 kg whose centre is the scene's centroid and whose inertia is
/// mass k_r / k_t in every direction: rotation then has the natural frequency of translation (100
/// rad/s at 1000 N/m), at which a step of 1 ms is stable, and a body as small as a ball
/// of 5 mm radius does not need a shorter one.
class VirtualCoupling {
 public:
  VirtualCoupling(const Coupling& coupling, const Pose& start);

  double mass() const { return kMass; }
  double inertia() const { return inertia_; }  ///< about the centroid, every axis [kg m^2]

  /// Sets the hand's next pose X_WH (of the centroid's frame), which it reaches at constant speed.
  /// Call it once per millisecond.
  void MoveHand(const Pose& X_WH);
  /// Returns the wrench on the tool about its centroid.  Pose and twist are those before the step.
  Wrench Pull(const Pose& X_WG, const Twist& V_WG);
  /// Returns the spring's part of the last Pull, on the hand; the damper's part would add noise.
  const Wrench& on_hand() const { return on_hand_; }

 private:
  static constexpr double kMass = 0.1;  // [kg]
  Coupling coupling_;
  double inertia_, damping_, torsional_damping_;
  Pose X_WH_;
  Twist V_WH_;
  Wrench on_hand_;
};

}  // namespace palpate::bench
