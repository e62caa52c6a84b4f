#pragma once

#include <cstdint>
#include <optional>

#include "common/math/pose.h"
#include "common/math/rotation.h"

namespace palpate {

/// The rotation nearest to a matrix that is one but for noise, in the Frobenius norm: the
/// orthogonal factor of its polar decomposition, by Newton's iteration (Higham, SIAM J. Sci. Stat.
/// Comput. 7 (1986) 1160-1174).  Nothing where the matrix is farther than 0.1 from it, mirrors, or
/// is not finite: that is no noise.  Real-time.  Deterministic: +, -, *, / alone.
std::optional<Mat3> NearestRotation(const Mat3& matrix) noexcept;

/// Angular velocity in W by differences of the rotations, with a first-order low-pass: for arms
/// whose library gives none, or one whose frame is not documented.  Real-time.
class TurnRate {
 public:
  explicit TurnRate(double rate_Hz) : rate_Hz_(rate_Hz) {}
  /// Of a difference from one tick to the next, what the low-pass takes in.
  double share() const noexcept {
    const double k = kCutOff_rad_s / rate_Hz_;
    return k / (1.0 + k);
  }

  /// Once per tick.
  Vec3 Of(const Quat& q_WH) noexcept {
    if (has_last_) {
      const Vec3 w = RotationLog(q_WH * last_.conjugate()) * rate_Hz_;
      w_ += share() * (w - w_);
    }
    last_ = q_WH;
    has_last_ = true;
    return w_;
  }
  /// The next rotation is the first.
  void Restart() noexcept {
    has_last_ = false;
    w_.setZero();
  }

 private:
  static constexpr double kCutOff_rad_s = 2.0 * 3.14159265358979 * 100.0;

  double rate_Hz_;
  Quat last_ = Quat::Identity();
  Vec3 w_ = Vec3::Zero();
  bool has_last_ = false;
};

/// Whether an arm that has no frames of its own gets what the limiter let through.  Below the
/// limiter, as a fault of the arm takes its force away in the same tick, where the limiter would
/// ramp out.  Closed from the beginning, and from each Fault on, until 0.1 s without one have
/// passed *and* the limiter asks for nothing at all: a closed gate is a fault to the station, so
/// the limiter gets there by itself, and the force comes back by its ramp, never by a step.
/// Counts ticks, reads no clock.  Real-time.  Not thread-safe: the tick's thread owns it.
class ReturnGate {
 public:
  static constexpr double kQuiet_s = 0.1;

  explicit ReturnGate(double rate_Hz)
      : quiet_needed_(static_cast<std::uint64_t>(kQuiet_s * rate_Hz)) {}

  void Fault() noexcept {
    open_ = false;
    quiet_ticks_ = 0;
  }
  /// Once per tick: whether this wrench may go out.
  bool Passes(const Wrench& limited) noexcept {
    ++quiet_ticks_;
    const bool nothing = limited.force.isZero(0.0) && limited.torque.isZero(0.0);
    if (!open_ && nothing && quiet_ticks_ > quiet_needed_) open_ = true;
    return open_;
  }
  bool open() const noexcept { return open_; }

 private:
  std::uint64_t quiet_needed_;
  std::uint64_t quiet_ticks_ = 0;
  bool open_ = false;
};

}  // namespace palpate
