#include "devices/wrench_limiter.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "common/error.h"

namespace palpate {
namespace {

/// Steepest slope of the smoothstep x^2 (3 - 2x).
constexpr double kSmoothstepSlope = 1.5;
/// Keeps a shortened vector inside its bound after rounding.
constexpr double kInside = 1.0 - 8.0 * std::numeric_limits<double>::epsilon();

/// Shortens v to the bound, direction kept; true where that was needed.  Does not overflow.
bool Shorten(Vec3& v, double bound) noexcept {
  const double largest = v.cwiseAbs().maxCoeff();
  if (largest == 0.0) return false;
  const Vec3 unit_ish = v / largest;  // norm in [1, sqrt 3]
  const double norm = unit_ish.norm();
  if (largest <= bound / norm) return false;
  v = unit_ish * (bound / norm * kInside);
  return true;
}

bool MoveTowards(Vec3& v, const Vec3& target, double max_step) noexcept {
  Vec3 step = target - v;
  const bool shortened = Shorten(step, max_step);
  v = shortened ? Vec3(v + step) : target;
  return shortened;
}

}  // namespace

WrenchLimits WrenchLimits::Of(const DeviceInfo& device) {
  WrenchLimits limits;
  limits.force_N = device.max_force_N;
  // Without a motor there is nothing to bound, and a bound must be positive.
  limits.torque_Nm = device.torque_axes > 0 ? device.max_torque_Nm : 1e-9;
  constexpr double kWholePeak_ms = 5.0;
  limits.force_slew_N_per_ms = device.max_force_N / kWholePeak_ms;
  limits.torque_slew_Nm_per_ms = limits.torque_Nm / kWholePeak_ms;
  return limits;
}

WrenchLimiter::WrenchLimiter(const WrenchLimits& limits) : limits_(limits) {
  const auto positive = [](double value, const char* name) {
    if (!(value > 0.0) || !std::isfinite(value)) {
      throw Error(std::string("wrench limits: ") + name + " is " + std::to_string(value) +
                  "; it must be positive and finite (does the device's info() give its peak force "
                  "and torque?)");
    }
  };
  positive(limits.force_N, "force_N");
  positive(limits.torque_Nm, "torque_Nm");
  positive(limits.force_slew_N_per_ms, "force_slew_N_per_ms");
  positive(limits.torque_slew_Nm_per_ms, "torque_slew_Nm_per_ms");
  positive(limits.fade_start_s, "fade_start_s");
  positive(limits.fade_end_s - limits.fade_start_s, "fade_end_s - fade_start_s");
  positive(limits.ramp_in_s, "ramp_in_s");
  positive(limits.ramp_out_s, "ramp_out_s");
  // |d(a e s)| <= |ds| + |s| (|da| + |de|): what the two factors may use of the slew limit.
  const double age_rate = std::max(kSmoothstepSlope / (limits.fade_end_s - limits.fade_start_s),
                                   1.0 / limits.ramp_in_s);
  const double enable_rate = 1.0 / std::min(limits.ramp_in_s, limits.ramp_out_s);
  const double factors = age_rate + enable_rate;
  force_rate_ = limits.force_slew_N_per_ms * 1e3 - limits.force_N * factors;
  torque_rate_ = limits.torque_slew_Nm_per_ms * 1e3 - limits.torque_Nm * factors;
  if (!(force_rate_ > 0.0) || !(torque_rate_ > 0.0)) {
    throw Error(
        "wrench limits: the slew limit leaves no room for the fade; raise force_slew_N_per_ms and "
        "torque_slew_Nm_per_ms above peak x (1.5 / fade + 1 / ramp_out)");
  }
}

double WrenchLimiter::AgeGain(double age_s, double dt_s) noexcept {
  if (age_s >= 0.0 && age_s <= limits_.fade_start_s) {
    armed_ = true;
    stale_ = false;
    age_gain_ = std::min(1.0, age_gain_ + dt_s / limits_.ramp_in_s);
  } else {
    if (armed_ && !stale_) ++counts_.fades;
    stale_ = true;
    const double fade = limits_.fade_end_s - limits_.fade_start_s;
    // NaN and negative ages fall through to 0: a reply from nowhere is as good as none.
    double left = 0.0;
    if (age_s > limits_.fade_start_s && age_s < limits_.fade_end_s) {
      const double x = (limits_.fade_end_s - age_s) / fade;
      left = x * x * (3.0 - 2.0 * x);
    }
    // Never up while stale; and no faster down than the smoothstep's own slope where the age jumps.
    age_gain_ = std::min(age_gain_, std::max(left, age_gain_ - kSmoothstepSlope * dt_s / fade));
    age_gain_ = std::max(age_gain_, 0.0);
  }
  return age_gain_;
}

double WrenchLimiter::EnableGain(double dt_s) noexcept {
  enable_gain_ = enabled_ ? std::min(1.0, enable_gain_ + dt_s / limits_.ramp_in_s)
                          : std::max(0.0, enable_gain_ - dt_s / limits_.ramp_out_s);
  return enable_gain_;
}

LimitedWrench WrenchLimiter::Limit(const Wrench& wanted, double age_s, double dt_s) noexcept {
  ++counts_.calls;
  const double dt = dt_s > 0.0 ? std::min(dt_s, kMaxTick_s) : 0.0;  // NaN counts as no time

  Wrench target = wanted;
  if (!target.force.allFinite() || !target.torque.allFinite()) {
    ++counts_.nonfinite;
    target = Wrench{};
  }

  const bool force_clamped = Shorten(target.force, limits_.force_N);
  const bool torque_clamped = Shorten(target.torque, limits_.torque_Nm);
  counts_.clamped += force_clamped || torque_clamped;

  const bool force_slewed = MoveTowards(slewed_.force, target.force, force_rate_ * dt);
  const bool torque_slewed = MoveTowards(slewed_.torque, target.torque, torque_rate_ * dt);
  counts_.slewed += force_slewed || torque_slewed;

  const double age_gain = AgeGain(age_s, dt);
  counts_.faded += age_gain < 1.0;
  const double enable_gain = EnableGain(dt);
  counts_.disabled += enable_gain < 1.0;

  const double gain = age_gain * enable_gain;
  return LimitedWrench({gain * slewed_.force, gain * slewed_.torque});
}

}  // namespace palpate
