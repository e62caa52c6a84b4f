#pragma once

#include <cstdio>
#include <string>

namespace palpate {

/// Formats a number with so many significant digits, for people: "0.123", "1.2e+04".
inline std::string Figure(double value, int digits) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
}

}  // namespace palpate
