#pragma once

#include <limits>
#include <string>

#include "common/files/whole_file.h"

namespace palpate {

/// Reads a file that a test has made, or that is in the repository, so its size needs no limit.
inline std::string ReadWholeFile(const std::string& file) {
  return ReadWholeFile(file, std::numeric_limits<std::uint64_t>::max());
}

}  // namespace palpate
