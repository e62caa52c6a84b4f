#pragma once

#include <cstdint>
#include <limits>

#include "devices/limiter/wrench_limits.h"

namespace palpate {

/// Warmth of a group of motors: a first-order model, driven by the square of what they give over
/// what they can give for ever (loss goes with the square of the current).
///   d(warmth)/dt = (u^2 - warmth) / time,   u = given / continuous
/// so that 1 is where the continuous figure leads, and the bound follows from it: the peak up to
/// kWarm, the continuous figure from 1 on, a smoothstep between.  As the bound at 1 is the
/// continuous figure, no input leads beyond 1 (but for one tick's step, peak^2 dt / time).
class MotorWarmth {
 public:
  static constexpr double kWarm = 0.5;

  MotorWarmth(double peak, double continuous, double time_s)
      : peak_(peak), continuous_(continuous), time_s_(time_s), bound_(peak) {}

  /// What may be given now; moves by at most `max_step`.
  double Bound(double max_step) noexcept;
  void Give(double amount, double dt_s) noexcept {
    const double u = amount / continuous_;
    warmth_ += (u * u - warmth_) * (dt_s / time_s_);
  }
  /// The device knows better where it is warmer than the model: it cannot see how warm the motors
  /// were at the start, nor the air around them.
  void Correct(double at_least) noexcept {
    if (at_least > warmth_) warmth_ = at_least;
  }
  double warmth() const noexcept { return warmth_; }
  double peak() const noexcept { return peak_; }

 private:
  double peak_, continuous_, time_s_;
  double bound_;
  double warmth_ = 0.0;
};

/// Shortens force and torque to what the motors stand: the peak while they are cool, the continuous
/// figures once they are warm.
class TemperatureStage {
 public:
  static constexpr double kShortest_s = 1.0;  ///< time constant, [s]
  /// The bound itself moves by no more than the peak in this time, though a device may report a
  /// temperature that leaps.
  static constexpr double kFastest_1_s = 5.0;

  explicit TemperatureStage(const WrenchLimits& limits);

  /// Factors, in (0, 1].
  struct Share {
    double force = 1.0, torque = 1.0;
  };
  /// @param motor_temperature  of the hottest motor as the device reports it, 0 cool to 1 its
  /// limit; anything else: not known.
  Share Pass(const Wrench& wanted, double motor_temperature, double dt_s) noexcept;
  /// What the motors were given in the end.
  void Give(const Wrench& applied, double dt_s) noexcept;

  /// Calls in which warmth held something back.
  std::uint64_t count() const noexcept { return count_; }
  /// Of the warmer group; 1: only the continuous figures are left.
  double warmth() const noexcept;

 private:
  MotorWarmth force_, torque_;
  std::uint64_t count_ = 0;
};

}  // namespace palpate
