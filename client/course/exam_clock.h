#pragma once

#include <cstdint>
#include <cstdlib>

namespace palpate {

/// The time of an exam, since 1970: the wall clock's when this process began, and from then on the
/// steady clock's, so that nobody gains or loses time when the computer's clock is set.  Only what
/// passes without a process is measured by the wall clock.
class ExamClock {
 public:
  ExamClock(std::int64_t wall_ns, std::int64_t steady_ns) : offset_ns_(wall_ns - steady_ns) {}

  std::int64_t Now_s(std::int64_t steady_ns) const { return (steady_ns + offset_ns_) / kSecond_ns; }
  /// Follows the wall clock if it was set by more than two seconds; less counts as its drift.
  /// Returns by how much [s]; all times that are compared with Now_s are to be moved by it.
  std::int64_t Follow(std::int64_t wall_ns, std::int64_t steady_ns) {
    const std::int64_t step_ns = wall_ns - steady_ns - offset_ns_;
    if (std::abs(step_ns) <= kDrift_ns) return 0;
    // In whole seconds, so that the times that are moved stay what they are.
    const std::int64_t step_s = (step_ns + (step_ns > 0 ? 1 : -1) * kSecond_ns / 2) / kSecond_ns;
    offset_ns_ += step_s * kSecond_ns;
    return step_s;
  }

 private:
  static constexpr std::int64_t kSecond_ns = 1'000'000'000, kDrift_ns = 2 * kSecond_ns;
  std::int64_t offset_ns_;
};

}  // namespace palpate
