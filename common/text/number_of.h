#pragma once

#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>

namespace palpate {

/// A text that is one number and nothing else, as std::from_chars takes it: no blanks, no plus.
/// @param base  of a whole number alone.
template <class Number, class... Base>
std::optional<Number> NumberOf(std::string_view text, Base... base) {
  Number number{};
  const char* const end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, number, base...);
  if (error != std::errc() || stopped != end) return std::nullopt;
  return number;
}

}  // namespace palpate
