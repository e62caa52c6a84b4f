#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace palpate {

/// Returns true if a request's Host header names this program: a numeric address, `localhost`, or a
/// name that the owner has configured, with any port, since proxies and containers map ports.  Any
/// other name might be that of an attacker's page whose DNS points here (DNS rebinding): the
/// browser would then treat our answers as that page's own.
///
/// The host's own name is not accepted by default: DHCP may set it, and with mDNS and LLMNR anybody
/// in the network can answer for it.  `--host-name "$(hostname)"` declares it trusted.
/// @param authority  the header as received.
/// @param names  configured names, in lower case.
bool IsOwnHost(std::string_view authority, const std::vector<std::string>& names);

/// The answer to a request that is refused for its Host.
struct HostRefusal {
  int status = 0;      ///< HTTP status
  std::string reason;  ///< for the client and the log; names the flag
};

/// Applies the rule of IsOwnHost to a request; nothing if it is accepted.
/// @param hosts    number of its Host headers.
/// @param authority  the first of them.
/// @param program  the program whose flag allows a name: "palpate-viewer".
std::optional<HostRefusal> RefuseHost(int hosts, std::string_view authority,
                                      const std::vector<std::string>& names,
                                      const std::string& program);

/// Returns true if a text can be a host name: letters, digits, '-', '_' and '.', at most 253.
bool IsHostName(std::string_view name);

}  // namespace palpate
