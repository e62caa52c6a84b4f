#include "devices/limiter/passivity_observer.h"

#include <algorithm>
#include <cmath>

#include "common/math/rotation.h"

namespace palpate {
namespace {

/// Comparisons with NaN are false.  Larger numbers than these no device reaches.
bool Usable(const Pose& X) noexcept {
  return (X.p.array().abs() <= 1e3).all() && std::abs(X.q.squaredNorm() - 1.0) <= 0.01;
}

}  // namespace

double PassivityObserver::Move(const Pose& X_WH) noexcept {
  way_ = Way{};
  seen_ = Usable(X_WH);
  if (!seen_) return 0.0;  // what was held meanwhile is booked with the next pose that is one
  const Pose now{X_WH.p, X_WH.q.normalized()};
  const Pose last = last_;
  last_ = now;
  leapt_ = !has_last_;
  has_last_ = true;
  if (leapt_) return 0.0;
  const Way way{now.p - last.p, RotationLog(now.q * last.q.conjugate())};
  leapt_ = way.p.norm() > kLeap_m || way.phi.norm() > kLeap_rad;
  if (leapt_) return 0.0;
  way_ = way;
  const double work = -(held_.force.dot(way.p) + held_.torque.dot(way.phi));
  energy_J_ += work;
  lowest_J_ = std::min(lowest_J_, energy_J_);
  return work;
}

}  // namespace palpate
