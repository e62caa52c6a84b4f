#pragma once

#include <string>
#include <string_view>

#include "common/error.h"

namespace palpate {

/// Returns a text behind its byte order mark, which editors of Windows put before UTF-8.  Throws
/// Error for a text in UTF-16, with or without a mark.
/// @param file  begins the message.
inline std::string_view WithoutMark(std::string_view text, const std::string& file) {
  if (text.starts_with("\xef\xbb\xbf")) return text.substr(3);
  const bool marked = text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff");
  // Of two bytes of an ASCII character, such as the first one, one is zero.
  if (marked || (text.size() >= 2 && (text[0] == '\0') != (text[1] == '\0'))) {
    throw Error(file + ": its text is UTF-16; save it as UTF-8");
  }
  return text;
}

}  // namespace palpate
