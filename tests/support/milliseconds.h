#pragma once

#include <cstdint>

namespace palpate {

/// A millisecond, in nanoseconds, which times are in.
inline constexpr std::int64_t kMs = 1'000'000;

}  // namespace palpate
