#pragma once

#include <cstdint>
#include <optional>

#include "common/math/pose.h"
#include "common/math/rotation.h"

namespace palpate {

/// Returns the rotation nearest, in the Frobenius norm, to a matrix that is a rotation with noise:
/// the orthogonal factor of its polar decomposition, by Newton's iteration (Higham, SIAM J. Sci.
/// Stat. Comput. 7 (1986) 1160-1174).  Returns nothing if the matrix is further than 0.1 from it,
/// is a reflection, or is not finite, which noise does not explain.  Real-time.  Deterministic: +,
/// -, *, / alone.
std::optional<Mat3> NearestRotation(const Mat3& matrix) noexcept;

/// Estimates the angular velocity in W [rad/s] from successive rotations, with a first-order
/// low-pass: for arms whose library gives none, or gives it in an undocumented frame.  Real-time.
class TurnRate {
 public:
  explicit TurnRate(double rate_Hz) : rate_Hz_(rate_Hz) {}
  /// Returns the weight that the low-pass gives to the newest difference.
  double share() const noexcept {
    const double k = kCutOff_rad_s / rate_Hz_;
    return k / (1.0 + k);
  }

  /// Takes the rotation of this tick and returns the velocity.  Call it once per tick.
  Vec3 Of(const Quat& q_WH) noexcept {
    if (has_last_) {
      const Vec3 w = RotationLog(q_WH * last_.conjugate()) * rate_Hz_;
      w_ += share() * (w - w_);
    }
    last_ = q_WH;
    has_last_ = true;
    return w_;
  }
  /// Forgets the past: the next rotation counts as the first.
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

/// A gate behind the limiter, for arms whose library has no frames.  It is needed because a fault
/// of the arm removes its force within the tick, while the limiter would ramp it out.  Closed at
/// first, and after each Fault until 0.1 s have passed without one *and* the limiter's output is
/// zero.  The station treats a closed gate as a fault, so the limiter goes to zero by itself, and
/// the force returns by its ramp and never by a step.  Counts ticks, reads no clock.  Real-time.
/// Not thread-safe: the tick's thread owns it.
class ReturnGate {
 public:
  static constexpr double kQuiet_s = 0.1;

  explicit ReturnGate(double rate_Hz)
      : quiet_needed_(static_cast<std::uint64_t>(kQuiet_s * rate_Hz)) {}

  void Fault() noexcept {
    open_ = false;
    quiet_ticks_ = 0;
  }
  /// Returns whether this wrench may be rendered.  Call it once per tick.
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
