#pragma once

#include <cstdint>

#include "common/math/pose.h"

namespace palpate {

/// The pose towards which a guide leads the hand.
struct GuideAim {
  std::uint64_t run = 0;  ///< identifies the guide; another number: another guide, or a restart
  Pose X_WH;
};

/// The largest wrench that a guide may apply, as norms.  Zero: none, as for a hand that accepts
/// no guide.
struct GuideLimits {
  /// The hand hardly notices this force at rest, and it pushes no tool through anything.
  static constexpr double kMostForce_N = 1.0;

  double force_N = 0.0;
  double torque_Nm = 0.0;

  /// Returns the limits for a force; the torque limit is 10 mN m per newton.  A force above
  /// kMostForce_N becomes kMostForce_N; a negative one, or NaN, becomes zero.
  static GuideLimits OfForce(double force_N);
};

/// A soft spring of bounded force that leads a hand towards a guide's aim.  The hand may always
/// overrule it:
///   reach    full force from 5 mm on and proportional below; full torque from 0.1 rad on
///   ramp     the force ramps in within 0.5 s each time that it starts
///   silence  an aim older than 50 ms counts less, one of 100 ms not at all
///   yield    while the hand is out of reach of the aim and does not follow (less than 5 mm/s
///            towards it), the force decreases, to zero after 0.8 s; it recovers at the same rate
///            once the hand follows.  After it has reached zero it stays there until the hand
///            itself has returned to within 5 mm; then it ramps in
///   leap     an aim that jumps (by more than 20 mm or 0.5 rad from one to the next) ramps in anew
/// Pure: time is an argument; equal inputs give equal bits.
/// Real-time: no allocation, lock, log or clock.  Not thread-safe: the loop's thread owns it.
class Guide {
 public:
  static constexpr double kReach_m = 0.005;
  static constexpr double kReach_rad = 0.1;
  static constexpr double kRamp_s = 0.5;
  static constexpr double kYield_s = 0.8;
  static constexpr double kYieldSpeed_m_s = 0.005;
  static constexpr std::int64_t kFresh_ns = 50'000'000;
  static constexpr std::int64_t kSilent_ns = 100'000'000;
  static constexpr double kLeap_m = 0.020;
  static constexpr double kLeap_rad = 0.5;

  /// Makes a guide that never pulls.
  Guide() = default;
  explicit Guide(const GuideLimits& limits) : limits_(limits) {}

  /// Takes the next aim; ignores one that is not finite or has no valid rotation.
  void Take(std::int64_t now_ns, const GuideAim& aim) noexcept;
  /// Returns force and torque on the hand at the handle's origin, in W.  Call it once per tick.
  Wrench Pull(std::int64_t now_ns, double dt_s, const Pose& X_WH, const Twist& V_WH) noexcept;

  const GuideLimits& limits() const noexcept { return limits_; }
  /// True after the hand has overruled the guide, until the hand returns to the aim.
  bool let_go() const noexcept { return let_go_; }

 private:
  GuideLimits limits_;
  GuideAim aim_;
  std::int64_t aim_ns_ = 0;
  bool has_aim_ = false;
  bool let_go_ = false;
  double ramp_ = 0.0;        // 0 to 1
  double resisted_s_ = 0.0;  // 0 to kYield_s
};

}  // namespace palpate
