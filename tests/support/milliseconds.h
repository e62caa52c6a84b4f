#pragma once

#include <cstdint>

namespace palpate {

/// A millisecond in nanoseconds, the unit of times.
inline constexpr std::int64_t kMs = 1'000'000;

}  // namespace palpate
