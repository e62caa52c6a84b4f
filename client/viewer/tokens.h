#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace palpate {

/// What a viewer may do; each includes those before it.  The last three are the roles of tokens.
enum class Access {
  kNone,
  kWatch,    ///< see
  kDrive,    ///< take a tool with the mouse, make a scene whole, steer a replay
  kOperate,  ///< decide about stations: admit, mute, take back
};

/// "watch", "drive", "operate", and "none".
const char* RoleName(Access access);
/// Of a token's role; nothing for another word.
std::optional<Access> ParseRole(std::string_view name);

/// Who may: tokens with a role and a name.  The file has a line for each,
///   ROLE NAME SHA256       operate teacher 9f86d081884c7d65…
/// with the token's hash in hexadecimal digits; empty lines and those that begin with '#' are
/// passed over.  No two names are one station's (StationNameOf).  A token is 256 random bits, so
/// that one round of SHA-256 keeps it: there is nothing to guess, and who reads the file cannot
/// present what it holds.
class Tokens {
 public:
  using Hash = std::array<unsigned char, 32>;
  struct Holder {
    Access role = Access::kNone;
    std::string name;
    Hash hash{};  ///< of the token itself: a new one of the same name is another
    bool operator==(const Holder&) const = default;
  };

  /// Throws Error: the file, the line and the remedy.
  static Tokens Read(const std::string& path);

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

  static Hash HashOf(std::string_view token);
  static Tokens Parse(const std::string& path, const std::string& text);

  std::vector<Holder> holders_;
};

/// What the station of who has a token of this name is called: [A-Za-z0-9_]{1,32}, '_' for what no
/// station's name has.  @param number  from the second one on it stands behind the name.
std::string StationNameOf(std::string name, int number = 1);

/// Makes a token, enters its hash at the file's end and returns it: it is kept nowhere else.  A
/// file that is not there is made, for its owner alone.
/// @param name  [A-Za-z0-9_.-]{1,32}, that no other line has.
/// Throws Error, UsageError.
std::string MakeToken(const std::string& path, Access role, const std::string& name);

}  // namespace palpate
