#pragma once

namespace palpate::test {

/// True where code runs at full speed, as in `release`: there a test of many random inputs runs in
/// full, elsewhere, where each takes ten times and more, with a share of them.
#if defined(__OPTIMIZE__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
inline constexpr bool kOptimised = true;
#else
inline constexpr bool kOptimised = false;
#endif

}  // namespace palpate::test
