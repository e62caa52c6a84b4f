#pragma once

#include <string>

namespace palpate {

/// The file that the one server of a `--domain` on this host holds locked, with its process id in
/// it (common/server_lock.h); for those who look for that server, who may lock it too, together
/// with others (LOCK_SH) and for a moment.
inline std::string ServerLockFile(int domain) {
  return "/tmp/palpate-server-" + std::to_string(domain) + ".lock";
}

}  // namespace palpate
