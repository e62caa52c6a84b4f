#include "devices/spacemouse/spacenav_reader.h"

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <sstream>
#include <vector>

#include <poll.h>
#include <signal.h>
#include <spdlog/spdlog.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

// Debian's spnav.h includes this X11 header for functions that are not used here, and libspnav-dev
// does not depend on it.
#define SPNAV_CONFIG_H_
#include <spnav.h>

#include "common/error.h"
#include "common/files/whole_file.h"

namespace palpate {
namespace {

constexpr const char* kDefaultSocket = "/var/run/spnav.sock";
constexpr const char* kConfiguration = "/etc/spnavrc";
constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 20;  // size limit of this
                                                              // configuration file
constexpr int kRetry_ms = 500;
constexpr int kOpenings = 20;
constexpr int kMostUnknown = 8;  // unknown frames in succession
constexpr ssize_t kFrameBytes = 32;

std::atomic<bool> in_use{false};

/// Returns the sockets that libspnav tries, in its order.
std::vector<std::string> Sockets() {
  std::vector<std::string> sockets;
  if (const char* named = std::getenv("SPNAV_SOCKET")) sockets.push_back(named);
  std::istringstream configuration(TryReadWholeFile(kConfiguration, kMostBytes).value_or(""));
  for (std::string line; std::getline(configuration, line);) {
    const std::size_t word = line.find_first_not_of(" \t");
    const std::size_t equals = line.find('=');
    if (word == std::string::npos || line.compare(word, 6, "socket") != 0 ||
        equals == std::string::npos) {
      continue;
    }
    const std::size_t begin = line.find_first_not_of(" \t", equals + 1);
    if (begin == std::string::npos) continue;
    sockets.push_back(line.substr(begin, line.find_last_not_of(" \t\r") + 1 - begin));
    break;
  }
  sockets.push_back(kDefaultSocket);
  return sockets;
}

/// Tries to connect; returns 0 or the errno.
int TryConnect(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) return ENAMETOOLONG;
  std::memcpy(address.sun_path, path.c_str(), path.size());
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return errno;
  const int error =
      connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 ? 0 : errno;
  close(fd);
  return error;
}

}  // namespace

void FindSpacenavd() {
  std::string tried;
  int error = ENOENT;
  for (const std::string& path : Sockets()) {
    const int now = TryConnect(path);
    if (now == 0) return;
    if (error == ENOENT)
      error = now;  // the error of an existing socket tells more than that of a
                    // missing one
    tried += (tried.empty() ? "" : ", ") + path + " (" + std::strerror(now) + ")";
  }
  std::string remedy;
  switch (error) {
    case ENOENT:
      remedy =
          "spacenavd does not run; install it (apt-get install spacenavd) and start it (systemctl "
          "start spacenavd), or name its socket in SPNAV_SOCKET";
      break;
    case ECONNREFUSED:
      remedy =
          "spacenavd has ended and left its socket; start it again (systemctl restart spacenavd)";
      break;
    case EACCES:
    case EPERM:
      remedy =
          "no permission for spacenavd's socket; let this user write to it ('ls -l' shows its "
          "permissions)";
      break;
    default:
      remedy = "see the reason given; SPNAV_SOCKET names another socket";
  }
  throw Error("spacemouse: no connection to spacenavd: tried " + tried + "; " + remedy);
}

namespace {

/// Opens libspnav's connection.  Throws Error.
void OpenLibrary() {
  for (int i = 0; i < kOpenings; ++i) {
    FindSpacenavd();  // spnav_open leaks if it fails, and does not tell why
    const auto began = std::chrono::steady_clock::now();
    errno = 0;  // libspnav reads errno after calls that do not set it
    if (spnav_open() < 0) continue;
    // No answer for 300 ms means a daemon before 1.0.  An answer of version 0 is the first word of
    // an event that arrived first; the rest of it would be taken for the next answer.
    const bool answered = std::chrono::steady_clock::now() - began < std::chrono::milliseconds(300);
    if (spnav_protocol() > 0 || !answered) return;
    spnav_close();
  }
  throw Error(
      "spacemouse: spacenavd accepts connections, but the protocol negotiation fails; do not touch "
      "the SpaceMouse while it is opened, or restart spacenavd");
}

/// Finds out whether spacenavd has a device, and its name.  Needs protocol 1.
bool FindDevice(std::string& name) {
  name = "its name is not known: spacenavd is older than 1.0";
  if (spnav_protocol() < 1) return true;
  // An event that arrives at the same time spoils the answer.
  for (int i = 0; i < 3; ++i) {
    char text[128] = "";
    errno = 0;
    if (spnav_dev_name(text, sizeof text) < 0) continue;
    name = text;
    return true;
  }
  return false;
}

}  // namespace

SpacenavReader::SpacenavReader() : stop_(eventfd(0, EFD_CLOEXEC)) {
  if (stop_ < 0)
    throw Error(
        "spacemouse: cannot create an eventfd; raise 'ulimit -n' if too many files are open");
  if (in_use.exchange(true)) {
    close(stop_);
    throw Error(
        "spacemouse: this process has already opened it, and libspnav supports only one "
        "connection");
  }
  std::future<void> opened = opened_.get_future();
  thread_ = std::thread([this] { Run(); });
  try {
    opened.get();
  } catch (...) {
    thread_.join();
    close(stop_);
    in_use.store(false);
    throw;
  }
}

SpacenavReader::~SpacenavReader() {
  const std::uint64_t one = 1;
  if (write(stop_, &one, sizeof one) < 0) {
    // The stop event is already signalled.
  }
  thread_.join();
  close(stop_);
  in_use.store(false);
}

bool SpacenavReader::StopsWithin(int milliseconds) const {
  pollfd wait{stop_, POLLIN, 0};
  return poll(&wait, 1, milliseconds) > 0;
}

void SpacenavReader::Run() {
  // libspnav writes to its socket even if the daemon has ended.
  sigset_t all;
  sigfillset(&all);
  pthread_sigmask(SIG_BLOCK, &all, nullptr);
  try {
    Open();
    opened_.set_value();
  } catch (...) {
    opened_.set_exception(std::current_exception());
    return;
  }
  for (;;) {
    Listen();
    spnav_close();
    if (StopsWithin(0)) return;
    Lose(SpacenavState::Link::kNoDaemon, "spacenavd has gone");
    for (bool back = false; !back;) {
      if (StopsWithin(kRetry_ms)) return;
      try {
        OpenLibrary();
        back = true;
      } catch (const Error& error) {
        spdlog::trace("{}", error.what());
      }
    }
    std::string name;
    if (FindDevice(name)) {
      state_.link = SpacenavState::Link::kUp;
      states_.Write(state_);
      spdlog::info("spacemouse: spacenavd is back");
    } else {
      Lose(SpacenavState::Link::kNoDevice, "spacenavd is back, without a device");
    }
  }
}

void SpacenavReader::Open() {
  OpenLibrary();
  if (FindDevice(device_name_)) return;
  spnav_close();
  throw Error(
      "spacemouse: spacenavd runs but has no device; plug the SpaceMouse in (lsusb shows it as "
      "3Dconnexion or Logitech), and check the log of spacenavd (journalctl -u spacenavd)");
}

void SpacenavReader::Lose(SpacenavState::Link link, const char* news) {
  state_ = {};
  state_.link = link;
  states_.Write(state_);
  spdlog::warn("spacemouse: {}: the tool stands still until it is back", news);
}

/// Listens until spacenavd closes the connection or sends invalid events, or the reader must stop.
void SpacenavReader::Listen() {
  int unknown = 0;
  for (;;) {
    pollfd wait[2] = {{spnav_fd(), POLLIN, 0}, {stop_, POLLIN, 0}};
    if (poll(wait, 2, -1) < 0) continue;
    if (wait[1].revents != 0) return;
    char frame[kFrameBytes];
    const ssize_t here = recv(wait[0].fd, frame, sizeof frame, MSG_PEEK | MSG_DONTWAIT);
    if (here <= 0) return;
    if (here < kFrameBytes) {  // libspnav would treat half a frame as a whole one
      if ((wait[0].revents & POLLHUP) != 0 || StopsWithin(1)) return;
      continue;
    }
    spnav_event event;
    // Zero means an event unknown to libspnav, such as an answer that came too late.
    if (spnav_poll_event(&event) == 0) {
      if (++unknown > kMostUnknown) return;
      continue;
    }
    unknown = 0;
    switch (event.type) {
      case SPNAV_EVENT_MOTION:
        state_.axes = {event.motion.x,  event.motion.y,  event.motion.z,
                       event.motion.rx, event.motion.ry, event.motion.rz};
        break;
      case SPNAV_EVENT_BUTTON: {
        if (event.button.bnum < 0 || event.button.bnum > 31) continue;
        const std::uint32_t bit = std::uint32_t{1} << event.button.bnum;
        state_.buttons = event.button.press ? state_.buttons | bit : state_.buttons & ~bit;
        break;
      }
      case SPNAV_EVENT_DEV:
        if (event.dev.op == SPNAV_DEV_RM) {
          Lose(SpacenavState::Link::kNoDevice, "the SpaceMouse is unplugged");
          continue;
        }
        if (state_.link == SpacenavState::Link::kNoDevice) {
          spdlog::info("spacemouse: the SpaceMouse is back");
        }
        state_.link = SpacenavState::Link::kUp;
        break;
      default:
        continue;
    }
    states_.Write(state_);
  }
}

}  // namespace palpate
