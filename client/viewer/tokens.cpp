#include "client/viewer/tokens.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <span>
#include <sstream>

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <openssl/crypto.h>
#include <sys/stat.h>
#include <unistd.h>

#include "client/course/person_name.h"
#include "common/error.h"
#include "common/files/private_file.h"
#include "common/files/whole_file.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

constexpr std::size_t kLongestName = 32;
/// Largest file: some nine thousand tokens.
constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 20;

bool IsLetterOrDigit(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

bool IsName(std::string_view name) {
  return !name.empty() && name.size() <= kLongestName && std::ranges::all_of(name, [](char c) {
    return IsLetterOrDigit(c) || c == '_' || c == '.' || c == '-';
  });
}

std::string ToHex(std::span<const unsigned char> bytes) {
  return fmt::format("{:02x}", fmt::join(bytes, ""));
}

/// Returns false unless the text has exactly the digits of these bytes.
bool FromHex(const std::string& hex, std::span<unsigned char> bytes) {
  std::size_t size = 0;
  return hex.size() == 2 * bytes.size() &&
         OPENSSL_hexstr2buf_ex(bytes.data(), bytes.size(), &size, hex.c_str(), '\0') == 1;
}

std::string TextOf(const std::string& path) {
  return ReadWholeFile(path, kMostBytes, "--tokens", IsPrivate("--tokens", path));
}

}  // namespace

Tokens Tokens::Parse(const std::string& path, const std::string& text) {
  Tokens tokens;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::istringstream words(line);
    std::string role, name, hash, more;
    words >> role;
    if (role.empty() || role.starts_with('#')) continue;
    words >> name >> hash >> more;
    const auto refuse = [&](const std::string& why) {
      throw Error(fmt::format("--tokens {}:{}: {}; palpate-viewer --make-token writes such lines",
                              path, number, why));
    };
    Holder entry;
    if (const auto known = ParseRole(role)) {
      entry = {*known, name, {}, 0, StationNameOf(name)};
    } else {
      refuse("role " + Quoted(role) + " is not known; give watch, drive or operate");
    }
    if (!IsName(name)) refuse("a name has letters, digits, '_', '.' and '-', 32 at most");
    if (!FromHex(hash, entry.hash) || !more.empty()) {
      refuse("the name is followed by the token's SHA-256, 64 hexadecimal digits, and no more");
    }
    for (const Holder& other : tokens.holders_) {
      if (other.name == name) refuse("the name " + Quoted(name) + " is listed twice");
      if (other.station == entry.station) {
        refuse("as a station " + Quoted(name) + " has the same name as " + Quoted(other.name) +
               ": " + Quoted(entry.station));
      }
      if (other.hash == entry.hash) refuse("it has the token of " + Quoted(other.name));
    }
    tokens.holders_.push_back(std::move(entry));
  }
  return tokens;
}

Tokens Tokens::Read(const std::string& path) {
  Tokens tokens = Parse(path, TextOf(path));
  if (tokens.holders_.empty()) {
    throw Error(
        fmt::format("--tokens {}: has no tokens, so nobody could watch; make one with "
                    "palpate-viewer --make-token operate NAME --tokens {}",
                    path, ShellWord(path)));
  }
  return tokens;
}

void Tokens::Add(Holder holder) {
  for (const Holder& other : holders_) {
    if (other.station != holder.station) continue;
    throw Error("--course: " + Quoted(holder.name) + " has the same name as " + Quoted(other.name) +
                " in --tokens; remove that line, or rename one of them");
  }
  holders_.push_back(std::move(holder));
}

std::optional<Tokens::Holder> Tokens::Find(std::string_view token) const {
  if (!LooksLikeToken(token)) return std::nullopt;
  const TokenHash hash = HashOfToken(token);
  std::optional<Holder> found;
  for (const Holder& holder : holders_) {
    if (CRYPTO_memcmp(holder.hash.data(), hash.data(), hash.size()) == 0) found = holder;
  }
  return found;
}

bool Tokens::Has(const Holder& holder) const {
  return std::ranges::find(holders_, holder) != holders_.end();
}

std::string Tokens::NameLike(std::string_view name) const {
  const NameLook look = LookOf(name);
  const auto found = std::ranges::find_if(
      holders_, [&](const Holder& holder) { return LookAlike(LookOf(holder.name), look); });
  return found == holders_.end() ? "" : found->name;
}

bool Tokens::NamesAnother(const std::string& station, const std::string& prefix,
                          const std::string& own) const {
  return std::ranges::any_of(holders_, [&](const Holder& holder) {
    return holder.station != own && StationNameOf(prefix + holder.station) == station;
  });
}

std::string MakeToken(const std::string& path, Access role, const std::string& name) {
  if (!IsName(name)) {
    throw UsageError("--make-token: the name " + Quoted(name) +
                     " may have at most 32 letters, digits, '_', '.' and '-'");
  }
  // A new file is readable by its owner only.
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
  if (file < 0) throw Error(fmt::format("--tokens {}: {}", path, std::strerror(errno)));
  close(file);
  const std::string before = TextOf(path);
  for (const Tokens::Holder& holder : Tokens::Parse(path, before).holders_) {
    if (holder.station == StationNameOf(name)) {
      throw UsageError(fmt::format(
          "--make-token: {} already has a token in {}; remove its line first, or give another name",
          Quoted(holder.name), path));
    }
  }
  const std::string token = RandomToken();
  std::ofstream end(path, std::ios::app);
  end << (before.empty() || before.ends_with('\n') ? "" : "\n")
      << fmt::format("{} {} {}\n", RoleName(role), name, ToHex(HashOfToken(token))) << std::flush;
  if (!end) throw Error(fmt::format("--tokens {}: {}", path, std::strerror(errno)));
  return token;
}

}  // namespace palpate
