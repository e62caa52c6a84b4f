#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "common/math/pose.h"

namespace palpate {

/// Factor that keeps a shortened vector within its bound despite rounding.
inline constexpr double kShortOfBound = 1.0 - 8.0 * std::numeric_limits<double>::epsilon();

/// Shortens a finite v to the bound and keeps its direction; returns true if that was needed.  Does
/// not overflow.  This is the projection on a ball, so two vectors are never further apart after it
/// than before.
inline bool Shorten(Vec3& v, double bound) noexcept {
  const double largest = v.cwiseAbs().maxCoeff();
  if (largest == 0.0) return false;
  const Vec3 unit_ish = v / largest;  // norm in [1, sqrt 3]
  const double norm = unit_ish.norm();
  if (largest <= bound / norm) return false;
  v = unit_ish * (bound / norm * kShortOfBound);
  return true;
}

/// Moves v towards the target by at most `max_step`; returns true if it did not reach the target.
inline bool MoveTowards(Vec3& v, const Vec3& target, double max_step) noexcept {
  Vec3 step = target - v;
  const bool shortened = Shorten(step, max_step);
  v = shortened ? Vec3(v + step) : target;
  return shortened;
}

/// Replaces a wrench that contains NaN or infinity by zero.
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

/// Shortens force and torque to their peaks and keeps their directions.
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

/// Follows its input at a bounded rate, starting from zero.
class SlewStage {
 public:
  /// @param force_N_s, torque_Nm_s  greatest rates of change.
  SlewStage(double force_N_s, double torque_Nm_s)
      : force_N_s_(force_N_s), torque_Nm_s_(torque_Nm_s) {}

  /// @param target  to follow.   @param dt_s  since the last call.
  /// @param felt  false: its last output was not rendered, so it may jump to the target.
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

/// A factor that starts at 0, ramps to 1 when forces are enabled, and ramps back faster.
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

/// A factor that falls from 1 to 0 (smoothstep) if replies stop, or answer poses that are too old,
/// and stays at 0 until a fresh one comes; then it rises by a ramp.  Zero before the first reply.
/// So a server that dies leaves no "last force".
class AgeStage {
 public:
  /// Silence, by the station's clock.  Up to three lost replies are not felt; a dead server is felt
  /// as a force that fades within 25 ms.
  static constexpr double kSilenceWhole_s = 0.004;
  static constexpr double kSilenceNone_s = 0.025;
  /// Age of the answered pose.  The steady round trip to a distant server is no fault; but beyond
  /// this age no stiff contact could be stable.
  static constexpr double kAgeWhole_s = 0.060;
  static constexpr double kAgeNone_s = 0.100;
  static constexpr double kRampIn_s = 0.200;
  /// Steepest slope of the fade: that of the smoothstep x^2 (3 - 2x) is 1.5, plus a little
  /// for rounding.
  static constexpr double kFastest_1_s = (1.5 + 1e-9) / (kSilenceNone_s - kSilenceWhole_s);

  /// @param silence_s  time since the newest usable reply arrived.
  /// @param age_s  time since the pose that it answers was sampled.
  /// @param dt_s  since the last call.
  /// Negative, NaN and infinite values count as no reply.
  /// While dt_s is at least the growth of silence_s, the factor is the smoothstep itself, zero by
  /// kSilenceNone_s.  If silence jumps, it falls at kFastest_1_s, to zero within 14 ms.
  double Gain(double silence_s, double age_s, double dt_s) noexcept;

  /// Calls with less than the whole wrench.
  std::uint64_t count() const noexcept { return count_; }
  /// Number of times that it began to fade after a fresh reply.
  std::uint64_t fades() const noexcept { return fades_; }
  bool fading() const noexcept { return armed_ && gain_ < 1.0; }

 private:
  bool armed_ = false;  // a fresh reply has come
  bool stale_ = true;   // the last call's reply was not fresh
  double gain_ = 0.0;
  std::uint64_t count_ = 0;
  std::uint64_t fades_ = 0;
};

/// First-order thermal model of a group of motors, driven by the square of their output over the
/// continuous output (heat loss is proportional to the square of the current):
///   d(warmth)/dt = (u^2 - warmth) / time,   u = given / continuous
/// The continuous output leads to a warmth of 1.  The bound on the output is the peak up to kWarm,
/// the continuous figure from 1 on, and a smoothstep between.  Since the bound at 1 is the
/// continuous figure, no input leads beyond 1 (except for one tick's step, peak^2 dt / time).
class MotorWarmth {
 public:
  static constexpr double kWarm = 0.5;

  MotorWarmth(double peak, double continuous, double time_s)
      : peak_(peak), continuous_(continuous), time_s_(time_s), bound_(peak) {}

  /// Returns the present bound, which changes by at most `max_step` per call.
  double Bound(double max_step) noexcept;
  void Give(double amount, double dt_s) noexcept {
    const double u = amount / continuous_;
    warmth_ += (u * u - warmth_) * (dt_s / time_s_);
  }
  /// Raises the warmth to a temperature that the device reports: the model does not know how warm
  /// the motors were at the start, nor the temperature of the air.
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

/// Shortens force and torque to what the motors can sustain: the peak while they are cool, the
/// continuous figures once they are warm.
class TemperatureStage {
 public:
  static constexpr double kShortest_s = 1.0;  ///< least time constant
  /// Greatest rate of the bound, as a share of the peak per second, since the temperature that a
  /// device reports may jump.
  static constexpr double kFastest_1_s = 5.0;

  /// @param force, torque  the motors as sources of force [N] and of torque [N m].
  TemperatureStage(const MotorWarmth& force, const MotorWarmth& torque)
      : force_(force), torque_(torque) {}

  /// Factors on force and torque, in (0, 1].
  struct Share {
    double force = 1.0, torque = 1.0;
  };
  /// @param wanted  wrench to reduce.   @param dt_s  since the last call.
  /// @param motor_temperature  DeviceSample::motor_temperature; above 1 it counts as 1; NaN and
  /// negative values count as unknown.
  Share Pass(const Wrench& wanted, double motor_temperature, double dt_s) noexcept;
  /// Takes the wrench that the motors were finally given.
  void Give(const Wrench& applied, double dt_s) noexcept;

  /// Number of calls in which warmth reduced the wrench.
  std::uint64_t count() const noexcept { return count_; }
  /// Warmth of the warmer group; at 1 only the continuous figures remain.
  double warmth() const noexcept;

 private:
  MotorWarmth force_, torque_;
  std::uint64_t count_ = 0;
};

}  // namespace palpate
