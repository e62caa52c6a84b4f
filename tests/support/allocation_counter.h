#pragma once

#include <cstdint>

namespace palpate::test {

/// Calls of operator new by this thread since it began.  Linking this replaces operator new, but
/// for sanitizer builds, where it counts nothing.
std::uint64_t AllocationsOfThisThread();

}  // namespace palpate::test
