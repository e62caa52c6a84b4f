#include "client/station/guide.h"

#include <algorithm>
#include <cmath>

#include "common/math/rotation.h"

namespace palpate {
namespace {

// As in the limiter: a tick after a stall counts as this long.
constexpr double kLongestTick_s = 0.002;
constexpr double kMaxCoordinate_m = 100.0;

/// Returns the limit in the direction of e, scaled down in proportion while e is within reach.
Vec3 Spring(const Vec3& e, double reach, double limit) noexcept {
  const double length = e.norm();
  return length > reach ? Vec3(e * (limit / length)) : Vec3(e * (limit / reach));
}

bool Leaps(const Pose& from, const Pose& to) noexcept {
  return (to.p - from.p).norm() > Guide::kLeap_m ||
         RotationLog(to.q.normalized() * from.q.conjugate()).norm() > Guide::kLeap_rad;
}

}  // namespace

GuideLimits GuideLimits::OfForce(double force_N) {
  const double force = force_N > 0.0 ? std::min(force_N, kMostForce_N) : 0.0;
  return {force, 0.01 * force};
}

void Guide::Take(std::int64_t now_ns, const GuideAim& aim) noexcept {
  // Comparisons with NaN are false.
  if (!(aim.X_WH.p.array().abs() <= kMaxCoordinate_m).all() ||
      !(std::abs(aim.X_WH.q.squaredNorm() - 1.0) <= 0.01)) {
    return;
  }
  // A guide that the hand has overruled stays off, whatever aim comes.
  if (!has_aim_ || aim.run != aim_.run || Leaps(aim_.X_WH, aim.X_WH)) ramp_ = 0.0;
  aim_ = aim;
  aim_.X_WH.q.normalize();
  aim_ns_ = now_ns;
  has_aim_ = true;
}

Wrench Guide::Pull(std::int64_t now_ns, double dt_s, const Pose& X_WH, const Twist& V_WH) noexcept {
  const std::int64_t age_ns = now_ns - aim_ns_;
  if (!has_aim_ || !(limits_.force_N > 0.0) || age_ns < 0 || age_ns >= kSilent_ns) {
    has_aim_ = false;
    return {};
  }
  const double fresh = age_ns <= kFresh_ns
                           ? 1.0
                           : static_cast<double>(kSilent_ns - age_ns) / (kSilent_ns - kFresh_ns);
  const double dt = dt_s > 0.0 ? std::min(dt_s, kLongestTick_s) : 0.0;

  const Vec3 e = aim_.X_WH.p - X_WH.p;
  const double distance = e.norm();
  const Vec3 turn = RotationLog(aim_.X_WH.q * X_WH.q.conjugate());
  if (!std::isfinite(distance) || !turn.allFinite() || !V_WH.v.allFinite()) return {};

  const bool out_of_reach = distance > kReach_m;
  if (let_go_) {
    if (out_of_reach) return {};
    let_go_ = false;
    resisted_s_ = 0.0;
    ramp_ = 0.0;
  }
  const bool resists = out_of_reach && V_WH.v.dot(e) < kYieldSpeed_m_s * distance;
  resisted_s_ = std::clamp(resisted_s_ + (resists ? dt : -dt), 0.0, kYield_s);
  if (resisted_s_ >= kYield_s) {
    let_go_ = true;
    return {};
  }
  ramp_ = std::min(1.0, ramp_ + dt / kRamp_s);
  const double gain = fresh * ramp_ * (1.0 - resisted_s_ / kYield_s);
  return {gain * Spring(e, kReach_m, limits_.force_N),
          gain * Spring(turn, kReach_rad, limits_.torque_Nm)};
}

}  // namespace palpate
