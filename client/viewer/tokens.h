#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/course/access.h"

namespace palpate {

/// The valid tokens, each with a role and a name.  The file has one line per token,
///   ROLE NAME SHA256       operate teacher 9f86d081884c7d65…
/// with the token's hash in hexadecimal digits; empty lines and lines that begin with '#' are
/// skipped.  No two names may give the same station name (StationNameOf).  Whoever reads the file
/// cannot present a token (TokenHash).
class Tokens {
 public:
  struct Holder {
    Access role = Access::kNone;
    std::string name;
    TokenHash hash{};         ///< of the token itself: tells a new token of the same name apart
    std::int64_t person = 0;  ///< of a course; 0: from --tokens
    std::string station;      ///< of its tools
    bool operator==(const Holder&) const = default;
  };

  /// Throws Error that names the file, the line and the remedy.
  static Tokens Read(const std::string& path);

  /// Adds a token.  Throws Error if its station name is taken.
  void Add(Holder holder);

  /// Returns the holder of a token, or nothing; in constant time.
  std::optional<Holder> Find(std::string_view token) const;
  /// Returns whether a holder found earlier still has the same token, role and name.
  bool Has(const Holder& holder) const;
  /// Returns the name that looks like this one; empty: none does.
  std::string NameLike(std::string_view name) const;
  /// Returns whether a station name belongs to a token whose station is not `own`.
  /// @param prefix  of all stations that are named after tokens.
  bool NamesAnother(const std::string& station, const std::string& prefix,
                    const std::string& own) const;
  std::size_t size() const { return holders_.size(); }

 private:
  friend std::string MakeToken(const std::string& path, Access role, const std::string& name);

  static Tokens Parse(const std::string& path, const std::string& text);

  std::vector<Holder> holders_;
};

/// Makes a token, appends its hash to the file and returns the token, which is stored nowhere.  A
/// missing file is created, readable by its owner only.
/// @param name  [A-Za-z0-9_.-]{1,32}, not yet in the file.
/// Throws Error, UsageError.
std::string MakeToken(const std::string& path, Access role, const std::string& name);

}  // namespace palpate
