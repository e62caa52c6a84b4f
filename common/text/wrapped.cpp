#include "common/text/wrapped.h"

#include <algorithm>
#include <string_view>

namespace palpate {

std::vector<std::string> Wrapped(const std::string& text, int width) {
  std::vector<std::string> lines(1);
  std::string_view rest = text;
  while (!rest.empty()) {
    const std::string_view word = rest.substr(0, rest.find(' '));
    rest.remove_prefix(std::min(rest.size(), word.size() + 1));
    std::string& line = lines.back();
    if (!line.empty() && static_cast<int>(line.size() + 1 + word.size()) > width) {
      lines.emplace_back(word);
    } else {
      line.append(line.empty() ? "" : " ").append(word);
    }
  }
  return lines;
}

}  // namespace palpate
