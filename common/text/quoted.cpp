#include "common/text/quoted.h"

#include <cstdint>
#include <cstdio>

namespace palpate {
namespace {

constexpr std::size_t kLongest = 40;

/// The first character of a text; size 0 if its bytes are not UTF-8.
struct Character {
  std::uint32_t code = 0;
  std::size_t size = 0;
};

Character FirstOf(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
  const std::uint8_t first = byte(0);
  if (first < 0x80) return {first, 1};
  const std::size_t size = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
  if (first < 0xc2 || first > 0xf4 || text.size() < size) return {};
  std::uint32_t code = first & (0xffu >> (size + 1));
  for (std::size_t i = 1; i < size; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return {};
    code = code << 6 | (byte(i) & 0x3fu);
  }
  // The least code point that needs this many bytes; below it the encoding is overlong.
  constexpr std::uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool is_surrogate = code >= 0xd800 && code < 0xe000;
  if (code < kLeast[size] || is_surrogate || code > 0x10ffff) return {};
  return {code, size};
}

bool IsPrintable(std::uint32_t code) {
  const bool is_control = code < 0x20 || (code >= 0x7f && code < 0xa0);
  const bool ends_line = code == 0x2028 || code == 0x2029;
  const bool turns = code == 0x200e || code == 0x200f || (code >= 0x202a && code <= 0x202e) ||
                     (code >= 0x2066 && code <= 0x2069);
  const bool is_none = (code & 0xfffe) == 0xfffe || (code >= 0xfdd0 && code <= 0xfdef);
  return !is_control && !ends_line && !turns && !is_none;
}

void PutEscape(std::string& out, std::uint32_t code, const char* form) {
  char text[12];
  std::snprintf(text, sizeof text, form, static_cast<unsigned>(code));
  out += text;
}

}  // namespace

std::string Printable(std::string_view text) {
  std::string shown;
  shown.reserve(text.size());
  while (!text.empty()) {
    const Character character = FirstOf(text);
    const std::size_t size = character.size > 0 ? character.size : 1;
    if (character.size == 0) {
      PutEscape(shown, static_cast<std::uint8_t>(text[0]), "\\x%02x");
    } else if (IsPrintable(character.code)) {
      shown += text.substr(0, size);
    } else if (character.code == '\n') {
      shown += "\\n";
    } else if (character.code == '\r') {
      shown += "\\r";
    } else if (character.code == '\t') {
      shown += "\\t";
    } else {
      PutEscape(shown, character.code, character.code < 0x80 ? "\\x%02x" : "\\u%04x");
    }
    text.remove_prefix(size);
  }
  return shown;
}

std::string_view BeginningOf(std::string_view text, std::size_t most) {
  if (text.size() <= most) return text;
  std::size_t end = most;
  // Does not cut within a character, which has at most four bytes.
  while (end > 0 && end + 3 > most && (static_cast<std::uint8_t>(text[end]) & 0xc0) == 0x80) --end;
  return text.substr(0, end);
}

std::string Quoted(std::string_view text) {
  const std::string_view begin = BeginningOf(text, kLongest);
  std::string quoted = "'";
  quoted += Printable(begin);
  return quoted += begin.size() < text.size() ? "…'" : "'";
}

std::string ShellWord(std::string_view word) {
  constexpr std::string_view kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_@%+=:,./-";
  if (!word.empty() && word.find_first_not_of(kPlain) == word.npos) return std::string(word);
  const bool is_printable = Printable(word) == word;
  std::string quoted = is_printable ? "'" : "$'";
  for (const char c : word) {
    if (is_printable && c == '\'') {
      quoted += "'\\''";
    } else if (is_printable || (c >= ' ' && c < 0x7f && c != '\'' && c != '\\')) {
      quoted += c;
    } else {
      PutEscape(quoted, static_cast<std::uint8_t>(c), "\\x%02x");
    }
  }
  return quoted + "'";
}

}  // namespace palpate
