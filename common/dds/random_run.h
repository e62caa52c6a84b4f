#pragma once

#include <cstdint>

namespace palpate {

/// The number of a run of a server, a station or a guide: so random that no two are alike, and
/// never 0, which stands for none.  Reads the kernel's random numbers; not real-time.
std::uint64_t RandomRun();

}  // namespace palpate
