#pragma once

#include <atomic>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <sys/types.h>

namespace palpate::test {

/// Observes whether the machine lets real processes run.  It does not depend on Palpate's own
/// data, so a defect of Palpate cannot look like a stall.  A stall is the time lost within 100
/// ms, at once or in parts, which makes no difference to a server that receives nothing
/// meanwhile.  It counts
///   - the lateness of a thread of its own,
///   - the time for which a thread of a watched process was ready to run, but waited for a
///   processor (/proc/PID/task/TID/schedstat),
///   - the time that the host of a virtual machine gave to others (steal, in /proc/stat).
class StallWitness {
 public:
  /// Watches this process, and those that are added later.
  StallWitness();
  ~StallWitness();
  StallWitness(const StallWitness&) = delete;
  StallWitness& operator=(const StallWitness&) = delete;

  void Watch(pid_t process);
  /// Returns the longest stall so far: the time lost within 100 ms [ms].
  double longest_ms() const { return longest_ms_.load(); }

 private:
  void Run();

  std::mutex mutex_;
  std::vector<pid_t> processes_;
  std::atomic<double> longest_ms_{0.0};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

/// A server ends a session after 100 ms without a pose (Session::kSilence_ns).  Between hand and
/// server two threads can be delayed one after the other, the station's and the server's receiving
/// thread, plus less than a tick; so one of them lost a third of the 100 ms or more.
inline constexpr double kStallThatEndsASession_ms = 33.0;

/// The result of one attempt of a test with real processes.
enum class Attempt {
  kShown,   ///< the test has observed what it expects
  kFailed,  ///< it has observed the contrary
  kSpoilt,  ///< neither: a program reports that a session was lost to silence
};

/// Makes an attempt, and repeats it only if it was spoilt and the witness observed a stall of
/// `stall_ms` meanwhile.  A session that is lost while the machine let all processes run is a
/// defect, and fails at once, so no defect is mistaken for a stall.  Where the machine spoils all
/// attempts nothing is shown: the test is skipped, with a message (testing::Test::IsSkipped).
testing::AssertionResult Shown(const std::function<Attempt(StallWitness&)>& attempt,
                               double stall_ms = kStallThatEndsASession_ms);

}  // namespace palpate::test
