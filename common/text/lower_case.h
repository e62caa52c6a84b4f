#pragma once

#include <string>
#include <string_view>

namespace palpate {

/// ASCII's letters made small, whatever the locale: for hosts, schemes, headers and
/// the endings of files.
inline std::string LowerCase(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

}  // namespace palpate
