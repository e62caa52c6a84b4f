#pragma once

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

}  // namespace palpate
