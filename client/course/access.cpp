#include "client/course/access.h"

#include <algorithm>

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

bool IsLetterOrDigit(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
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
  std::string station(name.substr(0, kLongestStation - after.size()));
  std::ranges::replace_if(
      station, [](char c) { return !IsLetterOrDigit(c); }, '_');
  return station + after;
}

}  // namespace palpate
