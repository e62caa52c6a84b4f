#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace palpate {

/// What a viewer may do.  Each level includes those before it; the last three are also the
/// roles of tokens.
enum class Access {
  kNone,
  kWatch,    ///< see
  kDrive,    ///< take a tool with the mouse, restore a whole scene, steer a replay
  kOperate,  ///< decide about stations: admit, mute, take back a tool
};

/// Returns "none", "watch", "drive" or "operate".
const char* RoleName(Access access);
/// Returns the role of that name, or nothing if it is no role of a token.
std::optional<Access> ParseRole(std::string_view name);

/// The SHA-256 of a token.  A token has 256 random bits, so one round is enough: it cannot be
/// guessed, and whoever reads the hash cannot present the token.
using TokenHash = std::array<unsigned char, 32>;
TokenHash HashOfToken(std::string_view token);
/// Returns a new token.  Throws Error if the system gives no random numbers.
std::string RandomToken();
/// Returns whether the text has the form of a token; any other text is refused before hashing.
/// A token can stand unescaped in an Authorization header (RFC 6750), a WebSocket subprotocol
/// and a URL fragment.
bool LooksLikeToken(std::string_view text);

/// Returns the text without leading and trailing white space.
std::string_view Trimmed(std::string_view text);

inline constexpr std::size_t kLongestStation = 32;  ///< IsStationName (common/dds/topics.h)

/// Returns the station name [A-Za-z0-9_]{1,32} for a name in ASCII, whose other characters become
/// '_'.
/// @param number  appended to the name from 2 on.
std::string StationNameOf(std::string_view name, int number = 1);

}  // namespace palpate
