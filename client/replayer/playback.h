#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "common/dds/network.h"

namespace palpate {

/// The recording that is replayed to viewers or leads a hand, with time range and network.
struct Playback {
  std::vector<std::string> files;  ///< a recording, or its splits in order
  double rate = 1.0;               ///< factor on the recorded pace
  bool loop = false;
  double from_s = 0.0;  ///< offset from the first sample that is replayed
  double to_s = std::numeric_limits<double>::infinity();
  int domain = 0;
  dds::Network network;
};

/// Returns the seconds between any two times.  Their difference may overflow a signed integer.
inline double SecondsBetween(std::int64_t from_ns, std::int64_t to_ns) {
  if (from_ns > to_ns) return -SecondsBetween(to_ns, from_ns);
  return 1e-9 * static_cast<double>(static_cast<std::uint64_t>(to_ns) -
                                    static_cast<std::uint64_t>(from_ns));
}

}  // namespace palpate
