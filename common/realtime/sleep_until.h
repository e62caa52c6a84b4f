#pragma once

#include <cstdint>

#include <time.h>

namespace palpate {

/// Sleeps until a time of SteadyNanoseconds' clock, to pace a loop.  Real-time.
inline void SleepUntil(std::int64_t time_ns) noexcept {
  timespec at{};
  at.tv_sec = time_ns / 1'000'000'000;
  at.tv_nsec = time_ns % 1'000'000'000;
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr) != 0) {
  }
}

}  // namespace palpate
