#pragma once

#include <array>
#include <cstdint>
#include <future>
#include <string>
#include <thread>

#include "common/realtime/latest_mailbox.h"

namespace palpate {

/// The latest state that spacenavd has reported.
struct SpacenavState {
  enum class Link { kUp, kNoDaemon, kNoDevice };
  Link link = Link::kUp;
  std::array<int, 6> axes{};  ///< x, y, z, rx, ry, rz [counts], as spacenavd gives them
  std::uint32_t buttons = 0;  ///< bit i: button i is down; buttons from 32 on are not reported
};

/// Throws Error, with the remedy, if nothing listens at spacenavd's socket, or this user may not
/// connect to it.
void FindSpacenavd();

/// Listens to spacenavd through libspnav, in a thread of its own: libspnav allocates, blocks while
/// it opens, and keeps its one connection per process in globals that only this thread touches. If
/// the daemon ends, the state says so with all axes and buttons at rest, one line goes to the log,
/// and the thread tries to reconnect twice a second.
/// Thread contract: Read from one thread; the others from the thread that made it.
class SpacenavReader {
 public:
  /// Opens the connection.  Throws Error, with the remedy, if nothing listens at spacenavd's socket
  /// (SPNAV_SOCKET, or the one in /etc/spnavrc, or /var/run/spnav.sock), if the rights are missing,
  /// if spacenavd has no device, or if this process has such a reader already.
  SpacenavReader();
  ~SpacenavReader();
  SpacenavReader(const SpacenavReader&) = delete;
  SpacenavReader& operator=(const SpacenavReader&) = delete;

  /// Returns the device's name from spacenavd; versions before 1.0 give none.
  const std::string& device_name() const { return device_name_; }
  /// Reads the newest state; false, with `state` unchanged, if none came since the last
  /// call.  Real-time.
  bool Read(SpacenavState& state) noexcept { return states_.Read(state); }

 private:
  void Run();
  void Open();
  void Listen();
  void Lose(SpacenavState::Link link, const char* news);
  bool StopsWithin(int milliseconds) const;

  LatestMailbox<SpacenavState> states_;
  SpacenavState state_;  // used by the thread
  std::string device_name_;
  std::promise<void> opened_;
  int stop_;  // eventfd
  std::thread thread_;
};

}  // namespace palpate
