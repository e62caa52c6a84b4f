#pragma once

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

/// The most that a page may do.
/// Browsers let any page of the web open a socket to this host, and say in Origin whose page it is.
/// This gateway's own (the same authority as Host, which IsOwnHost has passed), and what sends no
/// Origin and so is no browser, may do all.  Those that are allowed may drive: a teacher's
/// decisions are made on this gateway's page.  A page of this host's files, `file://`, may watch:
/// that is how the desktop applications of Foxglove and Lichtblick name themselves, and no page of
/// the web can. All others, sandboxed ones ("null") among them, may do nothing.
/// @param secure  over TLS: then a page that came in the clear is not this gateway's own.
Access AccessOfOrigin(std::string_view origin, std::string_view host, bool secure,
                      const std::vector<std::string>& allowed_origins);

}  // namespace palpate
