#pragma once

#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>

namespace palpate {

/// Parses a text that is one number and nothing else, as std::from_chars does: no blanks, no plus
/// sign.  Returns nothing if it is not.
/// @param base  for integers only.
template <class Number, class... Base>
std::optional<Number> NumberOf(std::string_view text, Base... base) {
  Number number{};
  const char* const end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, number, base...);
  if (error != std::errc() || stopped != end) return std::nullopt;
  return number;
}

}  // namespace palpate
