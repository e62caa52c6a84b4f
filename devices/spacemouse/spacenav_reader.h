#pragma once

#include <array>
#include <cstdint>
#include <future>
#include <string>
#include <thread>

#include "common/realtime/latest_mailbox.h"

namespace palpate {

/// What spacenavd said last.
struct SpacenavState {
  enum class Link { kUp, kNoDaemon, kNoDevice };
  Link link = Link::kUp;
  std::array<int, 6> axes{};  ///< x, y, z, rx, ry, rz [counts], as spacenavd gives them
  std::uint32_t buttons = 0;  ///< bit i: button i is down; those from 32 on are not told
};

/// Throws Error, with what to do, where nothing listens at spacenavd's socket, or this user may not
/// connect to it.
void FindSpacenavd();

/// Listens to spacenavd through libspnav, in a thread of its own: libspnav allocates, blocks while
/// it opens, and keeps its one connection per process in globals that only this thread touches.
/// Where the daemon goes, the state says so with all axes and buttons at rest, the log says it
/// once, and the thread tries twice a second to have it back. Thread contract: Read from one
/// thread; the others from that which made it.
class SpacenavReader {
 public:
  /// Opens the connection.  Throws Error, with what to do, where nothing listens at spacenavd's
  /// socket (SPNAV_SOCKET, or what /etc/spnavrc says, or /var/run/spnav.sock), where the rights are
  /// missing, where spacenavd has no device, or where this process has such a reader already.
  SpacenavReader();
  ~SpacenavReader();
  SpacenavReader(const SpacenavReader&) = delete;
  SpacenavReader& operator=(const SpacenavReader&) = delete;

  /// The device's name, as spacenavd gives it; spacenavd of before 1.0 gives none.
  const std::string& device_name() const { return device_name_; }
  /// The newest state; false, leaving `state` alone, where nothing came since the last.  Real-time.
  bool Read(SpacenavState& state) noexcept { return states_.Read(state); }

 private:
  void Run();
  void Open();
  void Listen();
  void Lose(SpacenavState::Link link, const char* news);
  bool StopsWithin(int milliseconds) const;

  LatestMailbox<SpacenavState> states_;
  SpacenavState state_;  // the thread's
  std::string device_name_;
  std::promise<void> opened_;
  int stop_;  // eventfd
  std::thread thread_;
};

}  // namespace palpate
