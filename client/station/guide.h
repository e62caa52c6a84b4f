#pragma once

#include <cstdint>

#include "common/math/pose.h"

namespace palpate {

/// Where a guide wants the hand to be.
struct GuideAim {
  std::uint64_t run = 0;  ///< another one: another guide, or the same anew
  Pose X_WH;
};

/// Most that a guide may do, as norms.  Zero: nothing, as for a hand that accepts none.
struct GuideLimits {
  /// A hand that is at rest hardly notices so little, and no tool is pushed through anything by it.
  static constexpr double kMostForce_N = 1.0;

  double force_N = 0.0;
  double torque_Nm = 0.0;

  /// 5 mN m for 0.5 N.  More than kMostForce_N, or no number, is taken for kMostForce_N, or none.
  static GuideLimits OfForce(double force_N);
};

/// Leads a hand towards where a guide wants it: a soft spring of bounded force.  It is a hint that
/// the hand may always overrule:
///   reach    the whole force from 5 mm on, in proportion below; the whole torque from 0.1 rad on
///   ramp     comes in within 0.5 s, whenever it comes
///   silence  an aim older than 50 ms counts less, one of 100 ms not at all
///   yield    where the hand is out of reach of the aim and does not give way (less than 5 mm/s
///            towards it), the force goes to zero within 0.8 s of that; half of it is back after
///            half of that time without.  Once at zero it stays there until the hand itself has
///            returned to within 5 mm; then it ramps in
///   leap     an aim that leaps (by more than 20 mm or 0.5 rad from one to the next) ramps in anew
/// Pure: time comes in as arguments, equal inputs give equal bits.
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

  /// Does nothing.
  Guide() = default;
  explicit Guide(const GuideLimits& limits) : limits_(limits) {}

  /// An aim that is not finite, or has no rotation, is none.
  void Take(std::int64_t now_ns, const GuideAim& aim) noexcept;
  /// Once per tick.  Force and torque on the hand at the handle's origin, in W.
  Wrench Pull(std::int64_t now_ns, double dt_s, const Pose& X_WH, const Twist& V_WH) noexcept;

  const GuideLimits& limits() const noexcept { return limits_; }
  /// True once the hand has overruled it, until it returns.
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
