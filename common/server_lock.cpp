#include "common/server_lock.h"

#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <string>
#include <thread>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include "common/error.h"
#include "common/server_lock_file.h"

namespace palpate {
namespace {

/// Who looks for a server shares the lock for a moment: seconds are for a host that stands still.
constexpr int kLooks = 5000;
constexpr std::chrono::milliseconds kLook{1};

/// False where another has the lock to itself.
bool Lock(int file) {
  for (int i = 0; i < kLooks; ++i) {
    if (flock(file, LOCK_EX | LOCK_NB) == 0) return true;
    if (flock(file, LOCK_SH | LOCK_NB) != 0) return false;
    flock(file, LOCK_UN);  // or two servers that start would each take the other for one who looks
    std::this_thread::sleep_for(kLook);
  }
  return false;
}

/// Of the process whose number the file holds: "palpate-server (pid 7)".
std::string HolderOf(int file) {
  char pid[32] = {};
  if (pread(file, pid, sizeof pid - 1, 0) <= 0) return "another program";
  std::string name;
  // None where it runs in another container.
  std::getline(std::ifstream(std::string("/proc/") + pid + "/comm"), name);
  return (name.empty() ? "another program" : name) + " (pid " + pid + ")";
}

}  // namespace

ServerLock::ServerLock(int domain) {
  const std::string path = ServerLockFile(domain);
  // Read-only suffices to lock, so that another user's server is seen too.
  file_ = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0644);
  if (file_ < 0 && errno == EACCES) file_ = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
  if (file_ < 0) throw Error(path + ": " + std::strerror(errno) + "; give another --domain");
  if (!Lock(file_)) {
    const std::string holder = HolderOf(file_);
    close(file_);
    throw Error("domain " + std::to_string(domain) + " is in use by " + holder +
                "; stop that one, or give another --domain");
  }
  const std::string pid = std::to_string(getpid());
  if (ftruncate(file_, 0) != 0 || pwrite(file_, pid.data(), pid.size(), 0) < 0) {
    // Only the message of a second server would suffer.
  }
}

ServerLock::~ServerLock() {
  close(file_);
}

std::vector<std::pair<int, std::string>> ServersOnThisHost(int most) {
  std::vector<std::pair<int, std::string>> servers;
  for (int domain = 0; domain <= most; ++domain) {
    const int file = open(ServerLockFile(domain).c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
    if (file < 0) continue;
    if (flock(file, LOCK_SH | LOCK_NB) != 0) servers.emplace_back(domain, HolderOf(file));
    close(file);
  }
  return servers;
}

}  // namespace palpate
