#pragma once

#include <atomic>
#include <cstdint>

namespace palpate::faults {

/// What the shim and the test share, in a file that both map.  All zeros is a clock that is right.
struct SteppedClock {
  std::atomic<std::int64_t> ahead_ns;  ///< of the wall clock, written by the test
  std::atomic<std::uint64_t> asked;    ///< how often it was asked for while it was not right
};
static_assert(std::atomic<std::int64_t>::is_always_lock_free, "it stands in shared memory");

/// The environment's name for that file.
inline constexpr const char* kSteppedClockFile = "PALPATE_TEST_STEPPED_CLOCK";

}  // namespace palpate::faults
