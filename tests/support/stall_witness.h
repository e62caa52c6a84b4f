#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <sys/types.h>

namespace palpate::test {

/// Watches, beside real processes, whether the machine let them run.  It knows nothing of Palpate,
/// so no defect of Palpate can look like a stall to it.  A stall is the most that was lost within
/// 100 ms, at once or bit by bit, which is the same to a server that hears nothing meanwhile, by
///   - a thread of its own that woke later than it was due,
///   - a thread of a watched process that was ready to run, and waited for a processor
///     (/proc/PID/task/TID/schedstat),
///   - a processor that the host of a virtual machine gave to others (steal, in /proc/stat).
class StallWitness {
 public:
  /// Watches this process, and those that are named later.
  StallWitness();
  ~StallWitness();
  StallWitness(const StallWitness&) = delete;
  StallWitness& operator=(const StallWitness&) = delete;

  void Watch(pid_t process);
  /// The longest stall so far: what was lost within 100 ms [ms].
  double longest_ms() const { return longest_ms_.load(); }

 private:
  void Run();

  std::mutex mutex_;
  std::vector<pid_t> processes_;
  std::atomic<double> longest_ms_{0.0};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// A server ends a session after 100 ms without a pose (Session::kSilence_ns).  Between the hand
/// and the server lie two threads that can be held up one after the other, the station's and the
/// server's receiving one, and less than a tick beside: so one of them lost a third of it or more.
inline constexpr double kStallThatEndsASession_ms = 33.0;

/// What one attempt of a test with real processes came to.
enum class Attempt {
  kShown,   ///< the test has seen what it is about
  kFailed,  ///< it has seen the contrary
  kSpoilt,  ///< neither: a session was lost to silence, by what a program itself says of it
};

/// Makes an attempt, and another one only where the last was spoilt and the witness saw the machine
/// stand still for `stall_ms` meanwhile.  A session that is lost while the machine let all
/// processes run is a defect, and fails at once: no defect passes for a stall.
testing::AssertionResult Shown(const std::function<Attempt(StallWitness&)>& attempt,
                               double stall_ms = kStallThatEndsASession_ms);

}  // namespace palpate::test
