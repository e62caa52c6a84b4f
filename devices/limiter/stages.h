#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "common/math/pose.h"
#include "devices/limiter/wrench_limits.h"

namespace palpate {

/// Keeps a shortened vector inside its bound after rounding.
inline constexpr double kShortOfBound = 1.0 - 8.0 * std::numeric_limits<double>::epsilon();

/// Shortens a finite v to the bound, direction kept; true where that was needed.  Does not
/// overflow. Projection on a ball: two vectors are never further apart after it than before.
inline bool Shorten(Vec3& v, double bound) noexcept {
  const double largest = v.cwiseAbs().maxCoeff();
  if (largest == 0.0) return false;
  const Vec3 unit_ish = v / largest;  // norm in [1, sqrt 3]
  const double norm = unit_ish.norm();
  if (largest <= bound / norm) return false;
  v = unit_ish * (bound / norm * kShortOfBound);
  return true;
}

/// Moves v towards the target by at most `max_step`; true where that was not the whole way.
inline bool MoveTowards(Vec3& v, const Vec3& target, double max_step) noexcept {
  Vec3 step = target - v;
  const bool shortened = Shorten(step, max_step);
  v = shortened ? Vec3(v + step) : target;
  return shortened;
}

/// A wrench with NaN or infinity in it counts as zero.
class FiniteStage {
 public:
  Wrench Pass(const Wrench& wrench) noexcept {
    if (wrench.force.allFinite() && wrench.torque.allFinite()) return wrench;
    ++count_;
    return {};
  }
  std::uint64_t count() const noexcept { return count_; }

 private:
  std::uint64_t count_ = 0;
};

/// Shortens force and torque to their peak, direction kept.
class ClampStage {
 public:
  ClampStage(double force_N, double torque_Nm) : force_N_(force_N), torque_Nm_(torque_Nm) {}

  Wrench Pass(Wrench wrench) noexcept {
    const bool force = Shorten(wrench.force, force_N_);
    const bool torque = Shorten(wrench.torque, torque_Nm_);
    count_ += force || torque;
    return wrench;
  }
  std::uint64_t count() const noexcept { return count_; }

 private:
  double force_N_, torque_Nm_;
  std::uint64_t count_ = 0;
};

/// Follows what it is given at a bounded rate, from zero on.
class SlewStage {
 public:
  /// @param force_N_s, torque_Nm_s  rates.
  SlewStage(double force_N_s, double torque_Nm_s)
      : force_N_s_(force_N_s), torque_Nm_s_(torque_Nm_s) {}

  /// @param felt  false: what it gave last was not rendered, so it may leap to the target.
  const Wrench& Pass(const Wrench& target, double dt_s, bool felt = true) noexcept {
    if (!felt) return value_ = target;
    const bool force = MoveTowards(value_.force, target.force, force_N_s_ * dt_s);
    const bool torque = MoveTowards(value_.torque, target.torque, torque_Nm_s_ * dt_s);
    count_ += force || torque;
    return value_;
  }
  std::uint64_t count() const noexcept { return count_; }
  double force_N_s() const noexcept { return force_N_s_; }
  double torque_Nm_s() const noexcept { return torque_Nm_s_; }

 private:
  double force_N_s_, torque_Nm_s_;
  Wrench value_;
  std::uint64_t count_ = 0;
};

/// A factor that starts at 0, ramps to 1 when forces are asked for, and back sooner than that.
class EnableStage {
 public:
  static constexpr double kRampIn_s = 0.200;
  static constexpr double kRampOut_s = 0.050;
  static constexpr double kFastest_1_s = 1.0 / kRampOut_s;

  void Enable(bool on) noexcept { enabled_ = on; }
  bool enabled() const noexcept { return enabled_; }

  double Gain(double dt_s) noexcept {
    gain_ = enabled_ ? std::min(1.0, gain_ + dt_s / kRampIn_s)
                     : std::max(0.0, gain_ - dt_s / kRampOut_s);
    count_ += gain_ < 1.0;
    return gain_;
  }
  /// Calls with less than the whole wrench.
  std::uint64_t count() const noexcept { return count_; }

 private:
  bool enabled_ = false;
  double gain_ = 0.0;
  std::uint64_t count_ = 0;
};

/// A factor that falls from 1 to 0 (smoothstep) as replies stay away, or as they come from too far
/// in the past, and stays there until a fresh one comes; from then on it climbs back by a ramp.
/// Zero before the first reply.  So a producer that dies leaves no "last force".
class AgeStage {
 public:
  /// Silence, by the station's clock.  A reply or three that are lost are not felt; a dead server
  /// is, as a force that melts within 25 ms.
  static constexpr double kSilenceWhole_s = 0.004;
  static constexpr double kSilenceNone_s = 0.025;
  /// Age of the pose that was answered.  A far server's steady round trip is no fault; beyond this
  /// nothing stiff could be stable anyway.
  static constexpr double kAgeWhole_s = 0.060;
  static constexpr double kAgeNone_s = 0.100;
  static constexpr double kRampIn_s = 0.200;
  /// Steepest slope of the fade: the smoothstep x^2 (3 - 2x) has 1.5; and some for rounding.
  static constexpr double kFastest_1_s = (1.5 + 1e-9) / (kSilenceNone_s - kSilenceWhole_s);

  /// @param silence_s  since the newest usable reply arrived.  @param age_s  since the pose that it
  /// answers was sampled.  Negative, NaN or infinite: as good as none.
  /// While time passes as it should (dt_s is at least what silence_s grew by) the factor is the
  /// smoothstep itself, zero by kSilenceNone_s; where silence leaps it falls at kFastest_1_s, to
  /// zero within 14 ms.
  double Gain(double silence_s, double age_s, double dt_s) noexcept;

  /// Calls with less than the whole wrench.
  std::uint64_t count() const noexcept { return count_; }
  /// Times that it began to fade, after a fresh reply.
  std::uint64_t fades() const noexcept { return fades_; }
  bool fading() const noexcept { return armed_ && gain_ < 1.0; }

 private:
  bool armed_ = false;  // a fresh reply has come
  bool stale_ = true;   // the last call's was not fresh
  double gain_ = 0.0;
  std::uint64_t count_ = 0;
  std::uint64_t fades_ = 0;
};

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
