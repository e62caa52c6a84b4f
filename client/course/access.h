#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

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

/// SHA-256.  A token is 256 random bits, so that one round of it keeps the token: there is nothing
/// to guess, and who reads the hash cannot present the token.
using TokenHash = std::array<unsigned char, 32>;
TokenHash HashOfToken(std::string_view token);
/// A new one.  Throws Error where there are no random numbers.
std::string RandomToken();
/// Other text is no token, and is hashed nowhere.  Tokens fit an Authorization header (RFC 6750), a
/// WebSocket's subprotocol and a URL's fragment as they are.
bool LooksLikeToken(std::string_view text);

/// Without the white space at both ends.
std::string_view Trimmed(std::string_view text);

/// What the station of who has a token of this name is called: [A-Za-z0-9_]{1,32}.  Letters of
/// Western Europe lose their accents, other letters beyond ASCII become their number (x738b), and
/// '_' replaces the rest.
/// @param number  from the second one on it stands behind the name.
std::string StationNameOf(std::string_view name, int number = 1);

}  // namespace palpate
