#include "client/course/access.h"

#include <algorithm>
#include <cstdint>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <openssl/rand.h>
#include <openssl/sha.h>

#include "common/error.h"

namespace palpate {
namespace {

constexpr std::size_t kRandomBytes = 32;
/// Marks a token, so that one found in a log or a repository is recognised as such.
constexpr std::string_view kPrefix = "palpate_";
constexpr std::size_t kTokenLength = kPrefix.size() + 2 * kRandomBytes;
constexpr std::size_t kLongestStation = 32;  // IsStationName (common/dds/topics.h)
/// Unaccented letters for U+00C0 and the code points after it.
constexpr std::uint32_t kFirstAccent = 0xc0;
constexpr std::string_view kPlain =
    "AAAAAAACEEEEIIIIDNOOOOO_OUUUUYTsaaaaaaaceeeeiiiidnooooo_ouuuuyty";

bool IsLetterOrDigit(std::uint32_t c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

/// Removes the first code point of UTF-8 text and returns it; for malformed bytes,
/// an arbitrary one.
std::uint32_t TakeLetter(std::string_view& text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
  const std::size_t size = byte(0) < 0xc0 ? 1 : byte(0) < 0xe0 ? 2 : byte(0) < 0xf0 ? 3 : 4;
  std::uint32_t letter = size == 1 ? byte(0) : byte(0) & (0xffu >> (size + 1));
  std::size_t taken = 1;
  for (; taken < std::min(size, text.size()); ++taken) letter = letter << 6 | (byte(taken) & 0x3fu);
  text.remove_prefix(taken);
  return letter;
}

std::string InStation(std::uint32_t c) {
  if (IsLetterOrDigit(c)) return std::string(1, static_cast<char>(c));
  if (c < kFirstAccent) return "_";
  const std::size_t accent = c - kFirstAccent;
  return accent < kPlain.size() ? std::string(1, kPlain[accent]) : fmt::format("x{:x}", c);
}

}  // namespace

const char* RoleName(Access access) {
  static constexpr const char* kNames[] = {"none", "watch", "drive", "operate"};
  return kNames[static_cast<std::size_t>(access)];
}

std::optional<Access> ParseRole(std::string_view name) {
  for (const Access role : {Access::kWatch, Access::kDrive, Access::kOperate}) {
    if (name == RoleName(role)) return role;
  }
  return std::nullopt;
}

TokenHash HashOfToken(std::string_view token) {
  TokenHash hash;
  SHA256(reinterpret_cast<const unsigned char*>(token.data()), token.size(), hash.data());
  return hash;
}

std::string RandomToken() {
  unsigned char random[kRandomBytes];
  if (RAND_bytes(random, sizeof random) != 1) {
    throw Error("cannot make a token: no random numbers; check /dev/urandom");
  }
  return fmt::format("{}{:02x}", kPrefix, fmt::join(random, ""));
}

bool LooksLikeToken(std::string_view text) {
  return text.size() == kTokenLength && text.starts_with(kPrefix) &&
         std::ranges::all_of(text.substr(kPrefix.size()), IsLetterOrDigit);
}

std::string_view Trimmed(std::string_view text) {
  constexpr const char* kSpace = " \t\r\n";
  const std::size_t begin = text.find_first_not_of(kSpace);
  if (begin == text.npos) return "";
  return text.substr(begin, text.find_last_not_of(kSpace) + 1 - begin);
}

std::string StationNameOf(std::string_view name, int number) {
  const std::string after = number > 1 ? "_" + std::to_string(number) : "";
  std::string station;
  while (!name.empty()) station += InStation(TakeLetter(name));
  return station.substr(0, kLongestStation - after.size()) + after;
}

}  // namespace palpate
