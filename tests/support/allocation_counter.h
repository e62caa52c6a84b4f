#pragma once

#include <cstdint>

namespace palpate::test {

/// Times that this thread has asked for memory since it began, whoever asked: operator new, Eigen
/// (which calls malloc itself), a C library.  Linking this replaces malloc and its like, but for
/// sanitizer builds, which bring an allocator of their own: there it counts nothing.
std::uint64_t AllocationsOfThisThread();

/// False where it counts nothing.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kCountsAllocations = false;
#else
inline constexpr bool kCountsAllocations = true;
#endif

}  // namespace palpate::test
