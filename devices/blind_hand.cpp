#include "devices/blind_hand.h"

#include "common/math/rotation.h"

namespace palpate {
namespace {

/// Natural frequency [rad/s]: reaches 95 % of a step within 120 ms, and smooths the screen's 60 Hz.
constexpr double kFrequency = 40.0;

Vec3 Shortened(const Vec3& v, double bound) noexcept {
  const double norm = v.norm();
  return norm > bound ? Vec3(v * (bound / norm)) : v;
}

/// A critically damped spring of unit mass; semi-implicit Euler, stable at 1 kHz.  It does not
/// overshoot when it starts at the bounded speed.
void Pull(Vec3& velocity, const Vec3& way, double max_speed, double h) noexcept {
  const Vec3 faster = velocity + h * (kFrequency * kFrequency * way - 2.0 * kFrequency * velocity);
  velocity = Shortened(faster, max_speed);
}

}  // namespace

void BlindHand::LetGo() noexcept {
  X_WT_ = X_WG_;
  rate_.reset();
}

void BlindHand::SeeGraphicTool(const Pose& X_WG, const Vec3& p_HT) noexcept {
  X_WG_ = X_WG;
  p_HT_ = p_HT;
  lost_ = false;
}

void BlindHand::LoseGraphicTool() noexcept {
  if (!X_WG_) return;  // it has not pressed on anything
  X_WH_ = *X_WG_;
  v_ = w_ = Vec3::Zero();
  if (rate_) X_WT_ = X_WH_;  // no input draws it there, so it would press by itself
  held_back_ = false;
  lost_ = true;
}

void BlindHand::Step(double h) noexcept {
  if (lost_) return;
  const Vec3 at = X_WH_ * p_HT_;
  Vec3 to = X_WT_ ? *X_WT_ * p_HT_ : at;
  Quat turned_to = X_WT_ ? X_WT_->q : X_WH_.q;
  if (rate_ && X_WG_) {
    to += h * rate_->v;
    turned_to = (RotationExp(h * rate_->w) * turned_to).normalized();
  }
  held_back_ = false;
  if (X_WG_) {
    const Vec3 graphic = *X_WG_ * p_HT_;
    const Vec3 press = to - graphic;
    const Vec3 twist = RotationLog(turned_to * X_WG_->q.conjugate());
    held_back_ = press.norm() > kMaxPress_m || twist.norm() > kMaxTwist_rad;
    to = graphic + Shortened(press, kMaxPress_m);
    turned_to = RotationExp(Shortened(twist, kMaxTwist_rad)) * X_WG_->q;
  }
  if (rate_ && X_WG_) X_WT_ = Pose{to - turned_to * p_HT_, turned_to};
  Pull(v_, to - at, kMaxSpeed_m_s, h);
  Pull(w_, RotationLog(turned_to * X_WH_.q.conjugate()), kMaxTurn_rad_s, h);
  X_WH_.q = (RotationExp(h * w_) * X_WH_.q).normalized();
  X_WH_.p = at + h * v_ - X_WH_.q * p_HT_;
}

Twist BlindHand::twist() const noexcept {
  return {v_ - w_.cross(X_WH_.q * p_HT_), w_};
}

}  // namespace palpate
