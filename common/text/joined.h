#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace palpate {

/// The texts of a range with `between` between them: "a, b, c".
/// @param text_of  gives each one's text, or names the member that is it.
template <class Range, class TextOf = std::identity>
std::string Joined(const Range& range, TextOf text_of = {}, std::string_view between = ", ") {
  std::string all;
  for (const auto& one : range) {
    all.append(all.empty() ? "" : between).append(std::invoke(text_of, one));
  }
  return all;
}

}  // namespace palpate
