#include "client/course/course_lock.h"

#include <array>
#include <cerrno>
#include <cstring>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include "common/error.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

/// What the process that has the lock wrote into it.
std::string HolderIn(int fd) {
  std::array<char, 400> text{};
  const ssize_t size = pread(fd, text.data(), text.size(), 0);
  return Printable({text.data(), static_cast<std::size_t>(size < 0 ? 0 : size)});
}

}  // namespace

CourseLock::CourseLock(const std::string& folder) {
  const std::string file = folder + "/" + kFile;
  fd_ = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, S_IRUSR | S_IWUSR);
  if (fd_ >= 0 && flock(fd_, LOCK_EX | LOCK_NB) == 0) {
    Tell("an address that is not known yet");
    return;
  }
  const int error = errno;
  const std::string holder = fd_ >= 0 && error == EWOULDBLOCK ? HolderIn(fd_) : "";
  if (fd_ >= 0) close(fd_);
  if (error == EWOULDBLOCK) {
    throw Error(
        fmt::format("--course {}: a gateway already keeps this course ({}), and a second one would "
                    "cut its trials short; use that one, end it first, or give another --course",
                    folder, holder));
  }
  throw Error(
      fmt::format("{}: cannot be locked ({}); this user must be able to write the file and its "
                  "folder, on a disk that supports flock",
                  file, std::strerror(error)));
}

CourseLock::~CourseLock() {
  close(fd_);
}

void CourseLock::Tell(const std::string& address) const {
  const std::string text = fmt::format("process {}, at {}", getpid(), address);
  // Only read by people: nothing depends on whether it can be written.
  if (ftruncate(fd_, 0) == 0) [[maybe_unused]]
    const auto n = pwrite(fd_, text.data(), text.size(), 0);
}

}  // namespace palpate
