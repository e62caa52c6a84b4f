#pragma once

#include <chrono>
#include <cstdint>

namespace palpate {

/// Returns the time of this host's monotonic clock [ns].  For statistics and watchdogs; no force
/// depends on it. Real-time: no system call (vDSO).
inline std::int64_t SteadyNanoseconds() noexcept {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

}  // namespace palpate
