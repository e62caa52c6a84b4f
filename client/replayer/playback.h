#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "common/dds/network.h"

namespace palpate {

/// What is replayed to viewers or leads a hand, when, and where.
struct Playback {
  std::vector<std::string> files;  ///< a recording, or its splits in their order
  double rate = 1.0;               ///< times the recorded pace
  bool loop = false;
  double from_s = 0.0;  ///< into what is replayed
  double to_s = std::numeric_limits<double>::infinity();
  int domain = 0;
  dds::Network network;
};

/// From one time to another [s], whatever the two are: their difference as an integer may be none.
inline double SecondsBetween(std::int64_t from_ns, std::int64_t to_ns) {
  if (from_ns > to_ns) return -SecondsBetween(to_ns, from_ns);
  return 1e-9 * static_cast<double>(static_cast<std::uint64_t>(to_ns) -
                                    static_cast<std::uint64_t>(from_ns));
}

}  // namespace palpate
