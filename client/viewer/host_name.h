#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace palpate {

/// True for the Host of a request that is meant for this gateway: an address in numbers,
/// `localhost`, or a name that its owner has configured; with any port, since proxies and
/// containers map them.  Any other name may be one of somebody's page whose DNS leads here (DNS
/// rebinding): to the browser all that is answered would be that page's own.
///
/// The host's own name is not accepted by itself: DHCP may set it, and mDNS and LLMNR let
/// everybody in the network answer for it.  `--host-name "$(hostname)"` says that it is trusted.
/// @param authority  the header, as it came.   @param names  in small letters.
bool IsOwnHost(std::string_view authority, const std::vector<std::string>& names);

/// A name as a Host has it: letters, digits, '-', '_' and '.', 253 at most.
bool IsHostName(std::string_view name);

}  // namespace palpate
