#include "common/server_lock.h"

#include <cerrno>
#include <cstring>
#include <string>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "common/error.h"
#include "common/server_lock_file.h"

namespace palpate {

ServerLock::ServerLock(int domain) {
  const std::string path = ServerLockFile(domain);
  const std::string remedy = "; stop that one, or give another --domain";
  // Read-only suffices to lock, so that another user's server is seen too.
  file_ = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0644);
  if (file_ < 0 && errno == EACCES) file_ = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  if (file_ < 0) throw Error(path + ": " + std::strerror(errno) + "; give another --domain");
  if (flock(file_, LOCK_EX | LOCK_NB) != 0) {
    char pid[32] = {};
    const ssize_t n = pread(file_, pid, sizeof pid - 1, 0);
    close(file_);
    throw Error("domain " + std::to_string(domain) + " is in use by another palpate-server (pid " +
                (n > 0 ? pid : "unknown") + ")" + remedy);
  }
  const std::string pid = std::to_string(getpid());
  if (ftruncate(file_, 0) != 0 || pwrite(file_, pid.data(), pid.size(), 0) < 0) {
    // Only the message of a second server would suffer.
  }
}

ServerLock::~ServerLock() {
  close(file_);
}

}  // namespace palpate
