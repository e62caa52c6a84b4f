#pragma once

#include <limits>
#include <string>

#include "common/files/whole_file.h"

namespace palpate {

/// A file that a test has made, or that the repository holds: nothing to be bounded.
inline std::string ReadWholeFile(const std::string& file) {
  return ReadWholeFile(file, std::numeric_limits<std::uint64_t>::max());
}

}  // namespace palpate
