#pragma once

#include <cstdint>

namespace palpate {

/// From one time to another [s], whatever the two are: their difference as an integer may be none.
inline double SecondsBetween(std::int64_t from_ns, std::int64_t to_ns) {
  if (from_ns > to_ns) return -SecondsBetween(to_ns, from_ns);
  return 1e-9 * static_cast<double>(static_cast<std::uint64_t>(to_ns) -
                                    static_cast<std::uint64_t>(from_ns));
}

}  // namespace palpate
