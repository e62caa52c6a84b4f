#pragma once

#include <functional>
#include <string>
#include <string_view>

namespace palpate {

/// Returns the texts of a range, separated by `between`: "a, b, c".
/// @param text_of  gives an item's text: a function or a member.
template <class Range, class TextOf = std::identity>
std::string Joined(const Range& range, TextOf text_of = {}, std::string_view between = ", ") {
  std::string all;
  for (const auto& one : range) {
    all.append(all.empty() ? "" : between).append(std::invoke(text_of, one));
  }
  return all;
}

}  // namespace palpate
