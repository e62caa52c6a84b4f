#pragma once

#include <atomic>
#include <cstdint>

namespace palpate::faults {

/// Shared by the shim and the test through a file that both map.  All zeros is a clock that is
/// right.
struct SteppedClock {
  std::atomic<std::int64_t> ahead_ns;  ///< offset of the wall clock, written by the test
  std::atomic<std::uint64_t> asked;    ///< how often the program read it while it was wrong
};
static_assert(std::atomic<std::int64_t>::is_always_lock_free, "it stands in shared memory");

/// The environment variable that names the file.
inline constexpr const char* kSteppedClockFile = "PALPATE_TEST_STEPPED_CLOCK";

}  // namespace palpate::faults
