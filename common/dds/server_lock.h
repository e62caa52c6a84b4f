#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/dds/ports.h"

namespace palpate {

/// Ensures that there is only one server per `--domain` and host: while this object lives, it holds
/// a UDP port of the domain (common/dds/ports.h).  Like the domain's other ports, the lock applies
/// to all processes that share this host's network, in any folder or container, and ends with the
/// process.  A replay to viewers takes it too, because it publishes what a server does.
class ServerLock {
 public:
  /// Takes the lock.  If another user holds that port but no port of a participant in the domain,
  /// that process serves nobody: this is logged, and the server goes on without the lock.
  /// Throws Error (who holds the domain, remedy).
  explicit ServerLock(int domain);
  ~ServerLock();
  ServerLock(const ServerLock&) = delete;
  ServerLock& operator=(const ServerLock&) = delete;

 private:
  int socket_ = -1;
};

/// Returns the port of a domain that its server holds.
constexpr int ServerPort(int domain) {
  return dds::PortsOf(dds::LoopDomainId(domain)).last - 1;
}

/// Returns the process that holds a domain's server port; nothing if there is none, or if it
/// belongs to another user or runs in a container.
std::optional<int> ServerProcess(int domain);

/// Returns the servers of this host, as a hint for a user in the wrong domain: the domains from 0
/// to `most` that have one, each with its holder ("palpate-server (pid 7)").
std::vector<std::pair<int, std::string>> ServersOnThisHost(int most);

}  // namespace palpate
