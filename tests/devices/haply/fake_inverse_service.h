#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>

#include "devices/haply/inverse_client.h"

namespace palpate::test {

/// An Inverse Service that has an Inverse3 and a wireless VerseGrip, as its maker documents 3.5: a
/// full state with the first message, and one reply for each that comes.  In a thread of its own,
/// at a port that the system gives.  One client at a time.
/// Thread contract: all may be called from any one other thread.
class FakeInverseService {
 public:
  FakeInverseService();
  ~FakeInverseService();

  haply::Address address() const { return {"127.0.0.1", std::to_string(port_)}; }
  /// As kill(1) does: connection and port are gone.
  void Die();
  /// It listens again, at the same port.
  void ComeBack();
  /// It keeps the connection, and answers nothing any more; false: it goes on.
  std::atomic<bool> stalls{false};
  std::atomic<int> delay_ms{0};  ///< before each reply

  // Of the state that it sends, in its own frame.
  std::atomic<bool> calibrated{true};
  std::atomic<bool> grip_there{true};
  std::atomic<std::uint32_t> buttons{0};
  void SetPosition(const std::array<double, 3>& position);
  void SetOrientation(const std::array<double, 4>& wxyz);
  /// Is sent in place of each reply; empty: the truth again.
  void Lie(const std::string& text);
  /// Is sent in place of the first message.
  void LieFirst(const std::string& text);
  std::string FirstMessage();

  // What came of it.
  std::atomic<std::uint64_t> commands{0};
  std::atomic<std::int64_t> last_force_ns{0};  ///< when one that is not zero came last
  std::array<double, 3> force();               ///< of the newest command
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
