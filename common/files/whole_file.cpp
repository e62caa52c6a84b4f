#include "common/files/whole_file.h"

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/error.h"

namespace palpate {
namespace {

namespace fs = std::filesystem;

/// Bytes read at a time if a file does not report its size.
constexpr std::size_t kPiece = 64 * 1024;

[[noreturn]] void Refuse(const std::string& flag, const std::string& file, const std::string& why,
                         const std::string& remedy) {
  throw Error((flag.empty() ? "" : flag + " ") + file + ": " + why + "; " + remedy);
}

[[noreturn]] void RefuseUnreadable(const std::string& flag, const std::string& file, int error) {
  Refuse(flag, file, std::generic_category().message(error), "check the name and the rights");
}

/// Returns in words what a file is that is not regular.
const char* KindOf(mode_t mode) {
  if (S_ISDIR(mode)) return "is a folder";
  if (S_ISFIFO(mode)) return "is a pipe";
  if (S_ISSOCK(mode)) return "is a socket";
  return "is a device";
}

[[noreturn]] void RefuseKind(const std::string& flag, const std::string& file, mode_t mode) {
  Refuse(flag, file, KindOf(mode), "give the name of a regular file");
}

/// Returns "64 MiB": a size in the largest unit that divides it.
std::string InWords(std::uint64_t bytes) {
  const char* const units[] = {" bytes", " KiB", " MiB", " GiB"};
  std::size_t unit = 0;
  for (; unit < 3 && bytes > 0 && bytes % 1024 == 0; ++unit) bytes /= 1024;
  return std::to_string(bytes) + units[unit];
}

[[noreturn]] void RefuseLarge(const std::string& flag, const std::string& file,
                              std::uint64_t most) {
  Refuse(flag, file, "holds more than " + InWords(most) + ", the limit for such a file",
         "check that it is the right one, or make it smaller");
}

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) close(fd_);
  }
  Descriptor(Descriptor&& other) noexcept : fd_(other.Release()) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  int get() const { return fd_; }
  int Release() { return std::exchange(fd_, -1); }

 private:
  int fd_;
};

// NONBLOCK: open would wait for the writer of a pipe.  NOCTTY: a terminal would become this
// process's controlling terminal.
constexpr int kReading = O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY;

/// Returns the descriptor of a file that was just opened, if it is regular and passes the checks.
int Checked(Descriptor fd, const std::string& file, std::uint64_t most, const std::string& flag,
            const FileCheck& check) {
  struct stat status {};
  if (fd.get() < 0) {
    const int error = errno;
    // A socket cannot be opened at all; "No such device or address" would not explain that.
    if (stat(file.c_str(), &status) == 0 && S_ISSOCK(status.st_mode)) {
      RefuseKind(flag, file, status.st_mode);
    }
    RefuseUnreadable(flag, file, error);
  }
  if (fstat(fd.get(), &status) != 0) RefuseUnreadable(flag, file, errno);
  if (!S_ISREG(status.st_mode)) RefuseKind(flag, file, status.st_mode);
  if (check) check(status);
  if (static_cast<std::uint64_t>(status.st_size) > most) RefuseLarge(flag, file, most);
  return fd.Release();
}

std::string ReadAll(const Descriptor& fd, const std::string& file, std::uint64_t most,
                    const std::string& flag) {
  struct stat status {};
  if (fstat(fd.get(), &status) != 0) RefuseUnreadable(flag, file, errno);
  std::string text;
  std::size_t size = 0;
  // One byte more than the reported size, so that a file that does not grow is read in one piece.
  text.resize(status.st_size > 0 ? static_cast<std::size_t>(status.st_size) + 1 : kPiece);
  for (;;) {
    if (size == text.size()) text.resize(size + std::max(kPiece, size / 2));
    const ssize_t got = read(fd.get(), text.data() + size, text.size() - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) RefuseUnreadable(flag, file, errno);
    if (got == 0) break;
    size += static_cast<std::size_t>(got);
    if (size > most) RefuseLarge(flag, file, most);
  }
  text.resize(size);
  return text;
}

[[noreturn]] void RefuseLink(const std::string& path) {
  Refuse("", path, "is a link, which this program's folders do not have", "remove it");
}

/// Opens a folder below another without following a link between them.
Descriptor WalkTo(const std::string& folder, const fs::path& below) {
  Descriptor at(open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
  if (at.get() < 0) RefuseUnreadable("", folder, errno);
  fs::path path = folder;
  for (const fs::path& name : below.lexically_relative(folder)) {
    if (name == ".") continue;
    path /= name;
    if (name == "..") Refuse("", path, "is not below " + folder, "give a file that is");
    at = Descriptor(openat(at.get(), name.c_str(), O_PATH | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
    if (at.get() >= 0) continue;
    const int error = errno;
    if (fs::is_symlink(path)) RefuseLink(path);
    RefuseUnreadable("", path, error);
  }
  return at;
}

}  // namespace

int OpenRegularFile(const std::string& file, std::uint64_t most, const std::string& flag,
                    const FileCheck& check) {
  return Checked(Descriptor(open(file.c_str(), kReading)), file, most, flag, check);
}

int OpenFileBelow(const std::string& folder, const std::string& file, std::uint64_t most,
                  const FileCheck& check) {
  const Descriptor at = WalkTo(folder, fs::path(file).parent_path());
  Descriptor fd(openat(at.get(), fs::path(file).filename().c_str(), kReading | O_NOFOLLOW));
  if (fd.get() < 0 && errno == ELOOP) RefuseLink(file);
  return Checked(std::move(fd), file, most, "", check);
}

void RefuseLinks(const std::string& folder, const std::string& below) {
  WalkTo(folder, below);
}

std::string ReadWholeFile(const std::string& file, std::uint64_t most, const std::string& flag,
                          const FileCheck& check) {
  return ReadAll(Descriptor(OpenRegularFile(file, most, flag, check)), file, most, flag);
}

std::string ReadFileBelow(const std::string& folder, const std::string& file, std::uint64_t most,
                          const FileCheck& check) {
  return ReadAll(Descriptor(OpenFileBelow(folder, file, most, check)), file, most, "");
}

std::optional<std::string> TryReadWholeFile(const std::string& file, std::uint64_t most) {
  try {
    return ReadWholeFile(file, most);
  } catch (const Error&) {
    return std::nullopt;
  }
}

}  // namespace palpate
