#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace palpate {

/// What a WebSocket's client may do: nothing, look, or also take a tool with the mouse.
enum class Access { kNone, kLook, kAll };

/// Browsers let any page of the web open a socket to this host, and say in Origin whose page it is.
/// This gateway's own (the same authority as Host), those that are allowed, and what sends no
/// Origin and so is no browser, may do all.  A page of this host's files, `file://`, may look: that
/// is how the desktop applications of Foxglove and Lichtblick name themselves, and no page of the
/// web can.  All others, sandboxed ones ("null") among them, may do nothing.
/// A gateway for this host alone takes only hosts that are addresses, or localhost: a name that
/// somebody's DNS leads here is no way in.
Access AccessOf(std::string_view origin, std::string_view host, bool loopback_only,
                const std::vector<std::string>& allowed_origins);

}  // namespace palpate
