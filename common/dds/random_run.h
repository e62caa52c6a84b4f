#pragma once

#include <cstdint>

namespace palpate {

/// Returns a random 64-bit number for a run of a server, a station or a guide, so that no two
/// runs have the same; never 0, which stands for none.  Reads the kernel's random numbers;
/// not real-time.
std::uint64_t RandomRun();

}  // namespace palpate
