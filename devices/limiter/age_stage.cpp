#include "devices/limiter/age_stage.h"

#include <algorithm>

namespace palpate {
namespace {

/// 1 up to `whole`, 0 from `none` on; 0 for what is no time at all (comparisons with NaN are
/// false).
double Left(double time_s, double whole, double none) noexcept {
  if (time_s >= 0.0 && time_s <= whole) return 1.0;
  if (!(time_s > whole && time_s < none)) return 0.0;
  const double x = (none - time_s) / (none - whole);
  return x * x * (3.0 - 2.0 * x);
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
    // Never up while stale, and never faster down than the smoothstep is anywhere.
    gain_ = std::min(gain_, std::max(left, gain_ - kFastest_1_s * dt_s));
  }
  count_ += gain_ < 1.0;
  return gain_;
}

}  // namespace palpate
