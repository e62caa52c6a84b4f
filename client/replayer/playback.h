#pragma once

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

}  // namespace palpate
