#include "common/math/rotation.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/math/elementary.h"

namespace palpate {

Quat RotationExp(const Vec3& phi) noexcept {
  // Halves half the angle until it is small, evaluates the series, and squares the quaternion back.
  Vec3 h = 0.5 * phi;
  int doublings = 0;
  while (h.squaredNorm() > 0.0625 && doublings < 64) {
    h *= 0.5;
    ++doublings;
  }
  const double x = h.squaredNorm();  // (theta/2)^2 <= 1/16
  // sin(sqrt x)/sqrt x and cos(sqrt x), to x^8 / 17!.
  double sinc = 0.0;
  double cosine = 0.0;
  for (int k = 8; k >= 1; --k) {
    sinc = (1.0 + sinc) * (-x / ((2.0 * k) * (2.0 * k + 1.0)));
    cosine = (1.0 + cosine) * (-x / ((2.0 * k - 1.0) * (2.0 * k)));
  }
  Quat q(1.0 + cosine, (1.0 + sinc) * h.x(), (1.0 + sinc) * h.y(), (1.0 + sinc) * h.z());
  for (; doublings > 0; --doublings) q = q * q;
  const double inverse_norm = 1.0 / std::sqrt(q.squaredNorm());
  return Quat(q.w() * inverse_norm, q.x() * inverse_norm, q.y() * inverse_norm,
              q.z() * inverse_norm);
}

Vec3 RotationLog(const Quat& q) noexcept {
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  const double s = std::sqrt(q.x() * q.x() + q.y() * q.y() + q.z() * q.z());
  const double c = sign * q.w();
  // angle / s -> 2 / c as s -> 0; the ratio is well conditioned down to the smallest s.
  if (!(s > 1e-150)) return (2.0 * sign) * q.vec();
  const double scale = 2.0 * sign * Atan2(s, c) / s;
  return scale * q.vec();
}

Quat RotationBetween(const Vec3& from, const Vec3& to) noexcept {
  const Vec3 a = from.normalized();
  const Vec3 b = to.normalized();
  const double cosine = b.dot(a);
  if (cosine < -1.0 + 1e-12) {
    const Vec3 across = a.unitOrthogonal();
    return Quat(0.0, across.x(), across.y(), across.z());
  }
  const double s = std::sqrt((1.0 + cosine) * 2.0);  // twice the cosine of half the angle
  const Vec3 axis = a.cross(b) * (1.0 / s);
  const Quat q(0.5 * s, axis.x(), axis.y(), axis.z());
  return cosine < 0.0 ? q.normalized() : q;  // for nearly opposite vectors s suffers
                                             // from cancellation
}

Vec3 RotationLogFrom(const Quat& q, Vec3& turn) noexcept {
  constexpr double kHalfTurn = std::numbers::pi, kTurn = 2.0 * std::numbers::pi;
  const Vec3 before = turn;
  const double turned = before.norm();
  turn = RotationLog(q);
  if (turned <= 0.5 * kHalfTurn || (turned <= kHalfTurn && before.dot(turn) >= 0.0)) return turn;
  // The twist about the axis of q = swing * twist.
  const Vec3 axis = before / turned;
  const double along = q.vec().dot(axis), length = std::sqrt(q.w() * q.w() + along * along);
  if (!(length > 1e-150)) return turn;
  const double c = q.w() / length, s = along / length;
  const double twisted = RotationLog(Quat(c, s, 0.0, 0.0)).x();
  const double angle = twisted + kTurn * std::round((turned - twisted) / kTurn);
  if (angle <= kHalfTurn) return turn;
  turn = angle * axis;
  return std::min(angle, kTurn) * axis;
}

Vec3 RotationDifference(const Vec3& a, const Vec3& b) noexcept {
  const Vec3 straight = a - b;
  const Vec3 difference = RotationLog(RotationExp(a) * RotationExp(b).conjugate());
  return (difference - straight).squaredNorm() <= std::numbers::pi * std::numbers::pi ? difference
                                                                                      : straight;
}

}  // namespace palpate
