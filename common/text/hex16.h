#pragma once

#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <string>

namespace palpate {

/// Returns a run or a hash as sixteen hexadecimal digits, as topics, recordings, logs and reports
/// show it.
inline std::string Hex16(std::uint64_t value) {
  char text[17];
  std::snprintf(text, sizeof text, "%016" PRIx64, value);
  return text;
}

}  // namespace palpate
