#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "client/course/access.h"

namespace palpate {

/// Who may: tokens with a role and a name.  The file has a line for each,
///   ROLE NAME SHA256       operate teacher 9f86d081884c7d65…
/// with the token's hash in hexadecimal digits; empty lines and those that begin with '#' are
/// passed over.  No two names are one station's (StationNameOf).  Who reads the file cannot present
/// what it holds (TokenHash).
class Tokens {
 public:
  struct Holder {
    Access role = Access::kNone;
    std::string name;
    TokenHash hash{};         ///< of the token itself: a new one of the same name is another
    std::int64_t person = 0;  ///< of a course; 0: of --tokens
    bool operator==(const Holder&) const = default;
  };

  /// Throws Error: the file, the line and the remedy.
  static Tokens Read(const std::string& path);

  /// One more.  Throws Error where another's station has the name of its.
  void Add(Holder holder);

  /// Whose token this is; nothing: nobody's.  Takes the same time for all of them.
  std::optional<Holder> Find(std::string_view token) const;
  /// What was found once is there still: the same token with the same role and name.
  bool Has(const Holder& holder) const;
  /// True for the name of a station that is the holder's of a token of another name.
  /// @param prefix  before all that are named so.
  bool NamesAnother(const std::string& station, const std::string& prefix,
                    const std::string& own) const;
  std::size_t size() const { return holders_.size(); }

 private:
  friend std::string MakeToken(const std::string& path, Access role, const std::string& name);

  static Tokens Parse(const std::string& path, const std::string& text);

  std::vector<Holder> holders_;
};

/// Makes a token, enters its hash at the file's end and returns it: it is kept nowhere else.  A
/// file that is not there is made, for its owner alone.
/// @param name  [A-Za-z0-9_.-]{1,32}, that no other line has.
/// Throws Error, UsageError.
std::string MakeToken(const std::string& path, Access role, const std::string& name);

}  // namespace palpate
