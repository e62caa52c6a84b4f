#pragma once

#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <string>

namespace palpate {

/// Sixteen digits: a run or a hash as topics, recordings, logs and reports write it.
inline std::string Hex16(std::uint64_t value) {
  char text[17];
  std::snprintf(text, sizeof text, "%016" PRIx64, value);
  return text;
}

}  // namespace palpate
