#pragma once

#include <string>
#include <string_view>

namespace palpate {

/// Returns a text with its ASCII letters in lower case, independent of the locale: for hosts,
/// schemes, headers and file extensions.
inline std::string LowerCase(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return lower;
}

}  // namespace palpate
