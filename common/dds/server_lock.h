#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "common/dds/ports.h"

namespace palpate {

/// One server per `--domain` and host: it has a UDP port of the domain (common/dds/ports.h) while
/// this object lives.  As with the domain's other ports, that counts for all who share this host's
/// network, in whichever folder or container they are, and ends with the process.  A replay to
/// viewers takes it too: it speaks as a server.
class ServerLock {
 public:
  /// Where another user has that port, and none of those by which one takes part in the domain, it
  /// says so in the log and goes on without: that one serves nobody.
  /// Throws Error (who holds the domain, remedy).
  explicit ServerLock(int domain);
  ~ServerLock();
  ServerLock(const ServerLock&) = delete;
  ServerLock& operator=(const ServerLock&) = delete;

 private:
  int socket_ = -1;
};

/// The port of a domain that its server holds.
constexpr int ServerPort(int domain) {
  return dds::PortsOf(dds::LoopDomainId(domain)).last - 1;
}

/// The process that holds a domain's server port; nothing where none does, or it is another user's,
/// or in a container.
std::optional<int> ServerProcess(int domain);

/// The servers of this host, for who looks in the wrong domain: domains from 0 to `most`, each with
/// who holds it ("palpate-server (pid 7)").
std::vector<std::pair<int, std::string>> ServersOnThisHost(int most);

}  // namespace palpate
