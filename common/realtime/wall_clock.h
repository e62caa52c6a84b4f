#pragma once

#include <chrono>
#include <cstdint>

namespace palpate {

/// This host's calendar, since 1970.  It may be set back: what measures time asks steady_clock.h.
inline std::int64_t WallClock_ns() noexcept {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}
inline std::int64_t WallClock_s() noexcept {
  return WallClock_ns() / 1'000'000'000;
}

}  // namespace palpate
