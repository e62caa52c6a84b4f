#pragma once

namespace palpate::test {

/// True if code runs at full speed, as in `release`.  Tests with many random inputs then use all of
/// them; in other builds, where each takes ten times as long or more, only a share.
#if defined(__OPTIMIZE__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
inline constexpr bool kOptimised = true;
#else
inline constexpr bool kOptimised = false;
#endif

}  // namespace palpate::test
