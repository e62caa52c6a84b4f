#pragma once

#include "common/math/pose.h"
#include "scenes/scene.h"
#include "tests/benchmarks/peers/peer.h"

namespace palpate::bench {

/// The spring and damper that tie a peer's tool to the hand (Colgate, Stanley & Brown, IROS 1995),
/// the same for all peers: 6 degrees of freedom, critically damped.
///
/// The tool is a body of `mass` whose centre is the scene's centroid and whose inertia is
/// mass k_r / k_t in every direction: rotation then has the natural frequency of translation (100
/// rad/s at 0.1 kg and 1000 N/m), at which a step of 1 ms is stable, and a body as small as a ball
/// of 5 mm radius does not need a shorter one.
class VirtualCoupling {
 public:
  VirtualCoupling(const Coupling& coupling, const PeerSettings& settings, const Pose& start);

  double mass() const { return mass_; }
  double inertia() const { return inertia_; }  ///< about the centroid, every axis [kg m^2]

  /// Once a millisecond: the hand goes to X_WH, here that of the centroid's frame, at one speed.
  void MoveHand(const Pose& X_WH);
  /// Wrench on the tool about its centroid, for sub-step i of n.  Poses and twist are those before
  /// it.
  Wrench Pull(const Pose& X_WG, const Twist& V_WG, int i, int n);
  /// The spring's part of the last Pull, on the hand: what is compared.  The damper's would be
  /// noise beside it.
  const Wrench& on_hand() const { return on_hand_; }

 private:
  Coupling coupling_;
  double mass_, inertia_, damping_, torsional_damping_;
  Pose X_WH_;
  Twist V_WH_;
  Wrench on_hand_;
};

}  // namespace palpate::bench
