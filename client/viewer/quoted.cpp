#include "client/viewer/quoted.h"

#include <algorithm>

namespace palpate {

std::string Quoted(std::string_view text) {
  std::string shown(text.substr(0, 40));
  std::ranges::replace_if(
      shown, [](char c) { return c == '\x7f' || (c >= 0 && c < ' '); }, '?');
  return "'" + shown + (text.size() > 40 ? "…'" : "'");
}

}  // namespace palpate
