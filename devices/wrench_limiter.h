#pragma once

#include <cstdint>

#include "common/math/pose.h"
#include "devices/device.h"

namespace palpate {

/// A wrench that a device may render: only WrenchLimiter makes one, so no other path to a device
/// compiles.
class LimitedWrench {
 public:
  const Wrench& wrench() const noexcept { return wrench_; }

 private:
  friend class WrenchLimiter;
  friend class WorkspaceDevice;  // which only turns one into the device's own frame and units
  explicit LimitedWrench(const Wrench& wrench) noexcept : wrench_(wrench) {}
  Wrench wrench_;
};

/// Bounds of a WrenchLimiter.  Force and torque are bounded as vectors, by their norm.
struct WrenchLimits {
  double force_N = 0.0;
  double torque_Nm = 0.0;
  /// Bounds on the change of the *output*, all stages together.
  double force_slew_N_per_ms = 0.0;
  double torque_slew_Nm_per_ms = 0.0;
  // Replies answer a pose of this station; their age is its own clock's, since that pose.
  double fade_start_s = 0.010;  ///< older than this, a reply begins to fade
  double fade_end_s = 0.030;    ///< and by this age it is zero
  double ramp_in_s = 0.200;     ///< from zero to the whole wrench, after a fade or when enabled
  double ramp_out_s = 0.050;    ///< from the whole wrench to zero, when disabled

  /// The device's peak figures.  The whole peak may come or go in 5 ms, 4.4 N/ms for 22 N: a hand
  /// that hits 1 N/mm at 0.5 m/s needs 0.5 N/ms, so a touch is never softened, a jump always is.
  static WrenchLimits Of(const DeviceInfo& device);
};

/// How often each stage had to act, in calls; `fades` counts events.
struct LimiterCounts {
  std::uint64_t calls = 0;
  std::uint64_t nonfinite = 0;
  std::uint64_t clamped = 0;
  std::uint64_t slewed = 0;
  std::uint64_t faded = 0;     ///< calls with less than the whole wrench because of age
  std::uint64_t fades = 0;     ///< times that replies stopped, after they had begun
  std::uint64_t disabled = 0;  ///< calls with less than the whole wrench because of enable
};

/// The one way to a device, an ordered chain of stages:
///   finite   a wrench with NaN or infinity in it counts as zero
///   clamp    force and torque are shortened to the device's peak, direction kept
///   slew     what is left moves towards that at a bounded rate
///   age      a factor that falls from 1 to 0 (smoothstep) as replies get old, and stays 0 until a
///            fresh one comes; it climbs back by a ramp.  Zero before the first reply
///   enable   a factor that starts at 0, and ramps to 1 when forces are asked for
/// So a producer that dies leaves no "last force": that is the failure to rule out.
/// The slew stage leaves room for the two factors, so that the output obeys the slew limit too.
/// Pure: time comes in as arguments, equal inputs give equal bits.
/// Real-time: no allocation, lock, log or clock.  Not thread-safe: the loop's thread owns it.
class WrenchLimiter {
 public:
  /// Longest tick that counts: after a stall the next step is no larger than that of 2 ms.
  static constexpr double kMaxTick_s = 0.002;

  /// Throws Error where a limit is not positive and finite, or where the slew limit is too low for
  /// the fade to end in time.
  explicit WrenchLimiter(const WrenchLimits& limits);

  /// Once per tick.
  /// @param wanted  wrench at the handle, in W; anything at all.
  /// @param age_s   age of the reply that `wanted` comes from; infinite before the first.
  /// @param dt_s    time since the last call.
  LimitedWrench Limit(const Wrench& wanted, double age_s, double dt_s) noexcept;

  void Enable(bool on) noexcept { enabled_ = on; }
  bool enabled() const noexcept { return enabled_; }
  /// True while old replies hold the wrench below what was asked for.
  bool fading() const noexcept { return armed_ && age_gain_ < 1.0; }
  const LimiterCounts& counts() const noexcept { return counts_; }
  const WrenchLimits& limits() const noexcept { return limits_; }

 private:
  double AgeGain(double age_s, double dt_s) noexcept;
  double EnableGain(double dt_s) noexcept;

  WrenchLimits limits_;
  double force_rate_;   // of the slew stage alone [N/s]
  double torque_rate_;  // [N m/s]
  Wrench slewed_;
  double age_gain_ = 0.0;
  double enable_gain_ = 0.0;
  bool armed_ = false;  // a fresh reply has come
  bool stale_ = true;   // the last reply was not fresh
  bool enabled_ = false;
  LimiterCounts counts_;
};

}  // namespace palpate
