#pragma once

#include <cstdint>
#include <future>
#include <mutex>
#include <string>
#include <thread>

#include "common/program/realtime.h"
#include "common/realtime/latest_mailbox.h"
#include "devices/haply/inverse_message.h"

namespace palpate::haply {

/// Names the service's address, as ws://HOST:PORT.
inline constexpr const char* kServiceVariable = "PALPATE_HAPLY_SERVICE";

struct Address {
  std::string host = "localhost";
  std::string port = "10001";
};
/// The variable's, or else the service's own.  Throws UsageError for one that is none.
Address ServiceAddress();
/// Whether somebody listens there.  Throws Error, with the remedy, where not.
void CheckService(const Address& address);

/// What the service said last.
struct ServiceState {
  bool up = false;
  Lie lie = Lie::kNone;
  Reading reading;  ///< the newest with which nothing was wrong
  std::uint64_t replies = 0;
  std::int64_t round_trip_ns = 0;  ///< of the newest reply: from its command's sending on
};

/// Speaks with the Inverse Service over a WebSocket, in a thread that owns the socket: JSON
/// allocates, and sockets wait.  Each Send is one message, and each message has one reply; the next
/// is sent when that has come, so no more than one force is ever on its way, however long the
/// service stalls.  A force is sent once: where no Send comes for 10 ms, zero is sent.  Where the
/// service goes, the state says so at once, and the thread tries twice a second to have it back.
/// Thread contract: Read and Send from one thread; the others from that which made it.
class InverseClient {
 public:
  /// @param wanted    id of the device; empty: the first.
  /// @param realtime  of its thread.   Throws Error, with the remedy.
  InverseClient(Address address, std::string wanted, const RealtimeOptions& realtime);
  ~InverseClient();
  InverseClient(const InverseClient&) = delete;
  InverseClient& operator=(const InverseClient&) = delete;

  const Inventory& inventory() const { return inventory_; }
  /// The newest state; false, leaving `state` alone, where nothing came since the last.  Real-time.
  bool Read(ServiceState& state) noexcept { return states_.Read(state); }
  /// Real-time: wakes the thread, and waits for nothing.
  void Send(const Vec3& force_W) noexcept;
  /// What happened since, for people, a line each.
  std::string TakeNews();

  class Link;

 private:
  void Run();
  void Serve(Link& link);
  void Take(const std::string& reply);
  void Say(const std::string& news);

  Address address_;
  std::string wanted_;
  RealtimeOptions realtime_;
  Inventory inventory_;
  LatestMailbox<Vec3> forces_;
  LatestMailbox<ServiceState> states_;
  ServiceState state_;  // the thread's
  std::mutex news_mutex_;
  std::string news_;
  std::promise<void> opened_;
  int wake_;  // eventfds
  int stop_;
  std::thread thread_;
};

}  // namespace palpate::haply
