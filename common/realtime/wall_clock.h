#pragma once

#include <chrono>
#include <cstdint>

namespace palpate {

/// Returns this host's calendar time since 1970.  It may be set back: to measure durations,
/// use steady_clock.h.
inline std::int64_t WallClock_ns() noexcept {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}
inline std::int64_t WallClock_s() noexcept {
  return WallClock_ns() / 1'000'000'000;
}

}  // namespace palpate
