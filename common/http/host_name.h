#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace palpate {

/// True for the Host of a request that is meant for the program that it has reached: an address in
/// numbers, `localhost`, or a name that its owner has configured; with any port, since proxies and
/// containers map them.  Any other name may be one of somebody's page whose DNS leads here (DNS
/// rebinding): to the browser all that is answered would be that page's own.
///
/// The host's own name is not accepted by itself: DHCP may set it, and mDNS and LLMNR let
/// everybody in the network answer for it.  `--host-name "$(hostname)"` says that it is trusted.
/// @param authority  the header, as it came.   @param names  in small letters.
bool IsOwnHost(std::string_view authority, const std::vector<std::string>& names);

/// Why a request is refused for its Host.
struct HostRefusal {
  int status = 0;      ///< of HTTP
  std::string reason;  ///< for whoever asks, and for the log; names the flag
};

/// The rule of IsOwnHost for a request; nothing: it may go on.
/// @param hosts    how many Host headers it has.   @param authority  the first of them.
/// @param program  whose flag lets a name in: "palpate-viewer".
std::optional<HostRefusal> RefuseHost(int hosts, std::string_view authority,
                                      const std::vector<std::string>& names,
                                      const std::string& program);

/// A name as a Host has it: letters, digits, '-', '_' and '.', 253 at most.
bool IsHostName(std::string_view name);

}  // namespace palpate
