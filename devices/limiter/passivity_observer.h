#pragma once

#include <cstdint>

#include "common/math/pose.h"

namespace palpate {

/// Way of the handle between two calls, in W: of its origin [m], and the rotation vector [rad].
struct Way {
  Vec3 p = Vec3::Zero();
  Vec3 phi = Vec3::Zero();
};

/// Keeps the account of the energy at the handle, in the time domain: a device holds what it was
/// told until it is told anew, so the work of each tick is what was held . the way that was made,
/// exactly, whatever the clock says (Hannaford & Ryu, "Time-domain passivity control of haptic
/// interfaces", IEEE T. Robotics and Automation 18 (2002) 1-10; that the observer of a held force
/// has no discretisation error: Ryu, Kim & Hannaford, IEEE T. Robotics 20 (2004) 772-776).
/// Positive: the hand has put in more than it got back.
/// Real-time; deterministic.
class PassivityObserver {
 public:
  /// Further than this in one call is not a motion of a hand (5 m/s for 10 ms): a clutch, or an
  /// encoder that lost count.  No work is booked for it.
  static constexpr double kLeap_m = 0.05;
  static constexpr double kLeap_rad = 0.5;

  /// Settles what was held since the last call.  Returns the work that the hand did [J].
  double Move(const Pose& X_WH) noexcept;
  /// What the device holds from now on.
  void Hold(const Wrench& applied) noexcept { held_ = applied; }

  /// False where the last pose was none: not finite, or no rotation.
  bool seen() const noexcept { return seen_; }
  /// True where the last pose was the first, or was reached by a leap.
  bool leapt() const noexcept { return leapt_; }
  const Way& way() const noexcept { return way_; }
  double energy_J() const noexcept { return energy_J_; }
  double lowest_J() const noexcept { return lowest_J_; }

 private:
  Pose last_;
  bool has_last_ = false;
  bool seen_ = false;
  bool leapt_ = true;
  Way way_;
  Wrench held_;
  double energy_J_ = 0.0;
  double lowest_J_ = 0.0;
};

}  // namespace palpate
