#pragma once

#include "common/math/pose.h"
#include "common/math/rotation.h"

namespace palpate {

/// Angular velocity in W by differences of the rotations, with a first-order low-pass: for arms
/// whose library gives none, or one whose frame is not documented.  Real-time.
class TurnRate {
 public:
  explicit TurnRate(double rate_Hz) : rate_Hz_(rate_Hz) {}

  /// Once per tick.
  Vec3 Of(const Quat& q_WH) noexcept {
    if (has_last_) {
      const double k = kCutOff_rad_s / rate_Hz_;
      const Vec3 w = RotationLog(q_WH * last_.conjugate()) * rate_Hz_;
      w_ += k / (1.0 + k) * (w - w_);
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

}  // namespace palpate
