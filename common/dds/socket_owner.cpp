#include "common/dds/socket_owner.h"

#include <charconv>
#include <filesystem>

namespace palpate {

std::optional<int> SocketOwner(const std::set<std::string>& sockets) {
  namespace fs = std::filesystem;
  std::error_code error;
  for (const auto& process : fs::directory_iterator("/proc", error)) {
    const std::string name = process.path().filename();
    int pid = 0;
    if (std::from_chars(name.data(), name.data() + name.size(), pid).ec != std::errc()) continue;
    std::error_code not_ours;
    for (const auto& file : fs::directory_iterator(process.path() / "fd", not_ours)) {
      std::error_code closed;
      if (sockets.contains(fs::read_symlink(file.path(), closed).string())) return pid;
    }
  }
  return std::nullopt;
}

}  // namespace palpate
