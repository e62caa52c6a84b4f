#include "tests/devices/spacemouse/fake_spacenavd.h"

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <stdexcept>
#include <vector>

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

namespace palpate::test {
namespace {

// Codes of spacenavd's protocol, from its src/proto.h.
constexpr std::int32_t kTag = 0x7faa0000;
constexpr std::int32_t kChangeProtocol = 0x5500;
constexpr std::int32_t kDeviceName = 0x2000;

}  // namespace

FakeSpacenavd::FakeSpacenavd(Options options) {
  char pattern[] = "/tmp/palpate-spnav-XXXXXX";
  if (!mkdtemp(pattern)) throw std::runtime_error("no folder for a socket");
  folder_ = pattern;
  path_ = folder_ + "/spnav.sock";
  setenv("SPNAV_SOCKET", path_.c_str(), 1);
  Start(options);
}

FakeSpacenavd::~FakeSpacenavd() {
  Kill();
  std::filesystem::remove_all(folder_);
}

void FakeSpacenavd::Start(Options options) {
  options_ = options;
  unlink(path_.c_str());
  listener_ = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strcpy(address.sun_path, path_.c_str());
  if (bind(listener_, reinterpret_cast<sockaddr*>(&address), sizeof address) != 0 ||
      listen(listener_, 8) != 0) {
    throw std::runtime_error("no socket at " + path_);
  }
  stop_ = eventfd(0, EFD_CLOEXEC);
  thread_ = std::thread([this] { Serve(); });
}

void FakeSpacenavd::Kill() {
  if (!thread_.joinable()) return;
  const std::uint64_t one = 1;
  if (write(stop_, &one, sizeof one) != sizeof one) std::abort();
  thread_.join();
  close(stop_);
  close(listener_);
}

void FakeSpacenavd::Serve() {
  for (;;) {
    pollfd wait[2] = {{listener_, POLLIN, 0}, {stop_, POLLIN, 0}};
    if (poll(wait, 2, -1) < 0) continue;
    if (wait[1].revents != 0) return;
    const int client = accept(listener_, nullptr, nullptr);
    if (client < 0) continue;
    Converse(client);
    {
      const std::lock_guard lock(sending_);
      client_.store(-1);
    }
    close(client);
  }
}

void FakeSpacenavd::Converse(int client) {
  int protocol = 0;
  // A client that only checks whether somebody listens sends nothing and closes.
  for (;;) {
    pollfd wait[2] = {{client, POLLIN, 0}, {stop_, POLLIN, 0}};
    if (poll(wait, 2, -1) < 0) continue;
    if (wait[1].revents != 0) return;
    std::array<std::int32_t, 8> frame{};
    const ssize_t size = recv(client, frame.data(), protocol == 0 ? 4 : sizeof frame, 0);
    if (size <= 0) return;
    if (protocol == 0 && (frame[0] & ~0xff) == (kTag | kChangeProtocol)) {
      if (options_.early_frames > 0) {
        --options_.early_frames;
        const std::array<std::int32_t, 8> early{0, 350, 0, 0, 0, 0, 0, 16};
        send(client, early.data(), sizeof early, MSG_NOSIGNAL);
      }
      if (options_.protocol > 0) {
        protocol = 1;
        const std::int32_t answer = kTag | kChangeProtocol | 1;
        send(client, &answer, sizeof answer, MSG_NOSIGNAL);
      }
      client_.store(client);
    } else if (protocol == 1) {
      if ((frame[0] & 0xffff) == kDeviceName && options_.has_device) {
        std::memcpy(&frame[1], "Fake Navigator", 14);
        frame[7] = 14;
      } else {
        frame[7] = -1;
      }
      send(client, frame.data(), sizeof frame, MSG_NOSIGNAL);
    }
  }
}

void FakeSpacenavd::SendBytes(const char* bytes, std::size_t count) {
  const std::lock_guard lock(sending_);
  if (client_.load() < 0) throw std::runtime_error("nobody is connected");
  send(client_.load(), bytes, count, MSG_NOSIGNAL);
}

void FakeSpacenavd::Send(const std::array<std::int32_t, 8>& frame) {
  SendBytes(reinterpret_cast<const char*>(frame.data()), sizeof frame);
}

void FakeSpacenavd::SendOften(const std::array<std::int32_t, 8>& frame, int times) {
  const std::vector frames(times, frame);
  SendBytes(reinterpret_cast<const char*>(frames.data()), times * sizeof frame);
}

void FakeSpacenavd::SendHalf(const std::array<std::int32_t, 8>& frame) {
  SendBytes(reinterpret_cast<const char*>(frame.data()), 13);
}

void FakeSpacenavd::SendInPieces(const std::array<std::int32_t, 8>& frame) {
  SendHalf(frame);
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  SendBytes(reinterpret_cast<const char*>(frame.data()) + 13, sizeof frame - 13);
}

}  // namespace palpate::test
