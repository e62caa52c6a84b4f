#pragma once

#include <cstdint>
#include <future>
#include <mutex>
#include <string>
#include <thread>

#include "common/program/realtime.h"
#include "common/realtime/latest_mailbox.h"
#include "devices/device.h"
#include "devices/haply/inverse_message.h"

namespace palpate::haply {

/// Environment variable with the service's address, as ws://HOST:PORT.
inline constexpr const char* kServiceVariable = "PALPATE_HAPLY_SERVICE";

struct Address {
  std::string host = "localhost";
  std::string port = "10001";
};
/// Returns the variable's address, or else the service's default.  Throws UsageError if it
/// is invalid.
Address ServiceAddress();
/// Throws Error, with the remedy, if nothing listens at the address.
void CheckService(const Address& address);

/// The latest state of the service.
struct ServiceState {
  bool up = false;
  Lie lie = Lie::kNone;
  Reading reading;  ///< the newest valid one
  std::uint64_t replies = 0;
  std::int64_t round_trip_ns = 0;  ///< of the newest reply, since its command was sent
};

/// A client of the Inverse Service over a WebSocket.  A thread owns the socket, because JSON
/// allocates and sockets block.  Each Send is one message with one reply; the next is sent only
/// after the reply, so at most one force is in transit, however long the service stalls.  A force
/// is sent once: if no Send follows within 10 ms, zero is sent.  If the connection is lost, the
/// state says so at once, and the thread tries to reconnect twice a second. Thread contract: Read
/// and Send from one thread; the others from the thread that made it.
class InverseClient {
 public:
  /// @param wanted    id of the device; empty: the first.
  /// @param realtime  for its thread.
  /// Throws Error, with the remedy.
  InverseClient(Address address, std::string wanted, const RealtimeOptions& realtime);
  ~InverseClient();
  InverseClient(const InverseClient&) = delete;
  InverseClient& operator=(const InverseClient&) = delete;

  const Inventory& inventory() const { return inventory_; }
  /// Reads the newest state; false, with `state` unchanged, if none came since the last
  /// call.  Real-time.
  bool Read(ServiceState& state) noexcept { return states_.Read(state); }
  /// Sends a force [N, in W].  Real-time: wakes the thread without waiting for it.
  void Send(const Vec3& force_W) noexcept;
  /// Returns the news since the last call, for people, one line each.
  DeviceNews TakeNews();

  class Link;

 private:
  void Run();
  void Serve(Link& link);
  void Take(const std::string& reply);
  void Say(std::string DeviceNews::*where, const std::string& news);

  Address address_;
  std::string wanted_;
  RealtimeOptions realtime_;
  Inventory inventory_;
  LatestMailbox<Vec3> forces_;
  LatestMailbox<ServiceState> states_;
  ServiceState state_;  // used by the thread
  std::mutex news_mutex_;
  DeviceNews news_;
  std::promise<void> opened_;
  int wake_;  // eventfds
  int stop_;
  std::thread thread_;
};

}  // namespace palpate::haply
