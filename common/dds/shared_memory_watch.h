#pragma once

#include <chrono>
#include <string>
#include <thread>

namespace palpate::dds {

/// Watchdog that ends the process, with a message that names the remedy, if an operation takes too
/// long.
/// iceoryx 2.0 keeps mutexes in shared memory, and one whose holder died stays locked for ever.  If
/// a process is killed in the middle of a write (one kill in some eighty where cores are scarce,
/// because the reader that it wakes may preempt it), RouDi then hangs, and so does every process
/// that makes or deletes an endpoint afterwards.  Loops go on, because they take samples without a
/// lock.  But a hanging main thread can neither be interrupted nor look after its sessions, and
/// only a restart of all processes helps.  While a session's endpoints are made or deleted no force
/// is rendered: forces have faded long before the patience is over.  Time during which the process
/// was stopped does not count.  Not real-time.
class SharedMemoryWatch {
 public:
  static constexpr std::chrono::milliseconds kPatience{10'000};

  explicit SharedMemoryWatch(std::string doing, std::chrono::milliseconds patience = kPatience);

 private:
  std::jthread thread_;
};

}  // namespace palpate::dds
