#pragma once

#include <cstdint>

namespace palpate::test {

/// Returns the number of allocations of this thread since it began, by any code: operator new,
/// Eigen (which calls malloc itself), a C library.  Linking this file replaces malloc and related
/// functions, except in sanitizer builds, whose own allocators are not counted.
std::uint64_t AllocationsOfThisThread();

/// False if nothing is counted.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kCountsAllocations = false;
#else
inline constexpr bool kCountsAllocations = true;
#endif

}  // namespace palpate::test
