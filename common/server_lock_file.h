#pragma once

#include <string>

namespace palpate {

/// The file that the one server of a `--domain` on this host holds locked, with its process id in
/// it (server/transport/server_lock.h); for those who look for that server.
inline std::string ServerLockFile(int domain) {
  return "/tmp/palpate-server-" + std::to_string(domain) + ".lock";
}

}  // namespace palpate
