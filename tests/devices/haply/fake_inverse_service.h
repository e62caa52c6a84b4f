#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>

#include "devices/haply/inverse_client.h"

namespace palpate::test {

/// An Inverse Service with an Inverse3 and a wireless VerseGrip, after the maker's documentation of
/// 3.5: the first message has the full state, and each message that comes gets one reply.  Runs in
/// a thread, at a port that the system chooses, for one client at a time.
/// Thread contract: every method may be called from one other thread.
class FakeInverseService {
 public:
  FakeInverseService();
  ~FakeInverseService();

  haply::Address address() const { return {"127.0.0.1", std::to_string(port_)}; }
  /// Closes connection and port, as kill(1) would.
  void Die();
  /// Listens again at the same port.
  void ComeBack();
  /// While true, keeps the connection open and answers nothing.
  std::atomic<bool> stalls{false};
  std::atomic<int> delay_ms{0};  ///< before each reply

  // The state that it sends, in its own frame.
  std::atomic<bool> calibrated{true};
  std::atomic<bool> grip_there{true};
  std::atomic<std::uint32_t> buttons{0};
  void SetPosition(const std::array<double, 3>& position);
  void SetOrientation(const std::array<double, 4>& wxyz);
  /// Sent in place of each reply; empty: the true reply again.
  void Lie(const std::string& text);
  /// Sent in place of the first message.
  void LieFirst(const std::string& text);
  std::string FirstMessage();

  // What the client sent.
  std::atomic<std::uint64_t> commands{0};
  std::atomic<std::int64_t> last_force_ns{0};  ///< when the last force other than zero came
  std::array<double, 3> force();               ///< that of the newest command
  std::string first_command();

 private:
  void Listen();
  void Run();
  void Serve(int connection);
  std::string State(bool first);

  int listener_ = -1;
  int port_ = 0;
  std::atomic<bool> dies_{false};
  std::mutex mutex_;
  std::array<double, 3> position_{0.0, -0.12, 0.15};
  std::array<double, 4> orientation_{1.0, 0.0, 0.0, 0.0};
  std::array<double, 3> force_{};
  std::string lie_, first_lie_, first_command_;
  std::thread thread_;
};

}  // namespace palpate::test
