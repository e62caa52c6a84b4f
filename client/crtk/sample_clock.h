#pragma once

#include <atomic>
#include <cstdint>

namespace palpate {

/// Turns the times of a station's steady clock into those of this host's system clock, which ROS
/// stamps with.  What is added is the least that a sample took to come here, seen lately: on one
/// host some tens of microseconds.  It may grow by 100 us a second, faster than two clocks drift
/// apart, and begins anew where a clock was set by more than a second.
/// Thread contract: Hear one thread, ToSystem any.
class SampleClock {
 public:
  /// A sample of that time has come.
  void Hear(std::int64_t sample_ns, std::int64_t system_ns) noexcept {
    const std::int64_t offset_ns = system_ns - sample_ns;
    const std::int64_t known_ns = offset_ns_.load(std::memory_order_relaxed);
    const std::int64_t allowed_ns = known_ns + (system_ns - heard_ns_) / kSlowness;
    const bool leaps =
        offset_ns - known_ns > kLeap_ns || known_ns - offset_ns > kLeap_ns || heard_ns_ == 0;
    heard_ns_ = system_ns;
    offset_ns_.store(leaps || offset_ns < allowed_ns ? offset_ns : allowed_ns,
                     std::memory_order_relaxed);
  }
  std::int64_t ToSystem(std::int64_t sample_ns) const noexcept {
    return sample_ns + offset_ns_.load(std::memory_order_relaxed);
  }

 private:
  static constexpr std::int64_t kSlowness = 10'000;
  static constexpr std::int64_t kLeap_ns = 1'000'000'000;
  std::atomic<std::int64_t> offset_ns_{0};
  std::int64_t heard_ns_ = 0;
};

}  // namespace palpate
