#include "devices/limiter/stages.h"

namespace palpate {
namespace {

/// Returns 1 up to `whole`, 0 from `none` on, and 0 for an invalid time (comparisons with NaN
/// are false).
double Left(double time_s, double whole, double none) noexcept {
  if (time_s >= 0.0 && time_s <= whole) return 1.0;
  if (!(time_s > whole && time_s < none)) return 0.0;
  const double x = (none - time_s) / (none - whole);
  return x * x * (3.0 - 2.0 * x);
}

double ShareWithin(const Vec3& v, double bound) noexcept {
  const double norm = v.norm();
  return norm <= bound ? 1.0 : bound / norm * kShortOfBound;
}

}  // namespace

double AgeStage::Gain(double silence_s, double age_s, double dt_s) noexcept {
  const double left = std::min(Left(silence_s, kSilenceWhole_s, kSilenceNone_s),
                               Left(age_s, kAgeWhole_s, kAgeNone_s));
  if (left == 1.0) {
    armed_ = true;
    stale_ = false;
    gain_ = std::min(1.0, gain_ + dt_s / kRampIn_s);
  } else {
    fades_ += armed_ && !stale_;
    stale_ = true;
    // Never rises while stale, and never falls faster than the smoothstep's steepest slope.
    gain_ = std::min(gain_, std::max(left, gain_ - kFastest_1_s * dt_s));
  }
  count_ += gain_ < 1.0;
  return gain_;
}

double MotorWarmth::Bound(double max_step) noexcept {
  const double cool = std::clamp((1.0 - warmth_) / (1.0 - kWarm), 0.0, 1.0);
  const double target = continuous_ + (peak_ - continuous_) * (cool * cool * (3.0 - 2.0 * cool));
  bound_ = std::clamp(target, bound_ - max_step, bound_ + max_step);
  return bound_;
}

TemperatureStage::Share TemperatureStage::Pass(const Wrench& wanted, double motor_temperature,
                                               double dt_s) noexcept {
  if (motor_temperature >= 0.0) {  // false for NaN
    const double hottest = std::min(motor_temperature, 1.0);
    force_.Correct(hottest);
    torque_.Correct(hottest);
  }
  const double force = force_.Bound(force_.peak() * kFastest_1_s * dt_s);
  const double torque = torque_.Bound(torque_.peak() * kFastest_1_s * dt_s);
  const Share share{ShareWithin(wanted.force, force), ShareWithin(wanted.torque, torque)};
  count_ += (share.force < 1.0 && force < force_.peak()) ||
            (share.torque < 1.0 && torque < torque_.peak());
  return share;
}

void TemperatureStage::Give(const Wrench& applied, double dt_s) noexcept {
  force_.Give(applied.force.norm(), dt_s);
  torque_.Give(applied.torque.norm(), dt_s);
}

double TemperatureStage::warmth() const noexcept {
  return std::max(force_.warmth(), torque_.warmth());
}

}  // namespace palpate
