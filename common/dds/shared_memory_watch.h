#pragma once

#include <chrono>
#include <string>
#include <thread>

namespace palpate::dds {

/// Ends the process, with the remedy, where what it watches over has not ended in time.
/// iceoryx 2.0 keeps mutexes in shared memory, and one whose holder died stays locked for ever: a
/// process killed in the middle of a write (one kill in some eighty where cores are short, for the
/// reader that it wakes may preempt it) takes with it RouDi and whoever makes or deletes an
/// endpoint after that.  Loops go on, for they take samples without a lock; but a main thread that
/// hangs can neither be interrupted nor look after its sessions, and nothing but a restart of all
/// mends it. Where a session's endpoints are made or deleted nothing is felt any more: forces have
/// faded long before the patience is over. Time is counted awake: a process that was stopped is
/// given the rest of its patience. Not real-time.
class SharedMemoryWatch {
 public:
  static constexpr std::chrono::milliseconds kPatience{10'000};

  explicit SharedMemoryWatch(std::string doing, std::chrono::milliseconds patience = kPatience);

 private:
  std::jthread thread_;
};

}  // namespace palpate::dds
