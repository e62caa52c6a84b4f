#pragma once

#include <algorithm>
#include <cstdint>

namespace palpate {

/// A factor that starts at 0, ramps to 1 when forces are asked for, and back sooner than that.
class EnableStage {
 public:
  static constexpr double kRampIn_s = 0.200;
  static constexpr double kRampOut_s = 0.050;
  static constexpr double kFastest_1_s = 1.0 / kRampOut_s;

  void Enable(bool on) noexcept { enabled_ = on; }
  bool enabled() const noexcept { return enabled_; }

  double Gain(double dt_s) noexcept {
    gain_ = enabled_ ? std::min(1.0, gain_ + dt_s / kRampIn_s)
                     : std::max(0.0, gain_ - dt_s / kRampOut_s);
    count_ += gain_ < 1.0;
    return gain_;
  }
  /// Calls with less than the whole wrench.
  std::uint64_t count() const noexcept { return count_; }

 private:
  bool enabled_ = false;
  double gain_ = 0.0;
  std::uint64_t count_ = 0;
};

}  // namespace palpate
