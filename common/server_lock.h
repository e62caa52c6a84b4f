#pragma once

#include <string>
#include <utility>
#include <vector>

namespace palpate {

/// One server per `--domain` and host: a file in /tmp, locked while this object lives.  The lock
/// goes with the process, so a killed server leaves none behind.  A replay to viewers takes it too:
/// it speaks as a server.
class ServerLock {
 public:
  /// Throws Error (who holds the domain, remedy).
  explicit ServerLock(int domain);
  ~ServerLock();
  ServerLock(const ServerLock&) = delete;
  ServerLock& operator=(const ServerLock&) = delete;

 private:
  int file_ = -1;
};

/// The servers of this host, for who looks in the wrong domain: domains from 0 to `most`, each with
/// who holds it ("palpate-server (pid 7)").
std::vector<std::pair<int, std::string>> ServersOnThisHost(int most);

}  // namespace palpate
