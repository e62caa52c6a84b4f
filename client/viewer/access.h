#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace palpate {

/// May a page use the WebSocket?  Browsers let any page of the web open a socket to this host, and
/// say in Origin whose page it is: it must be this gateway's own (the same authority as Host), or
/// one that is allowed.  What sends no Origin is no browser.
/// A gateway for this host alone takes only hosts that are addresses, or localhost: a name that
/// somebody's DNS leads here is no way in.
bool MayAttach(std::string_view origin, std::string_view host, bool loopback_only,
               const std::vector<std::string>& allowed_origins);

}  // namespace palpate
