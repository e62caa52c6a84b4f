#include "tests/support/stall_witness.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>

#include <unistd.h>

namespace palpate::test {
namespace {

using Clock = std::chrono::steady_clock;
using Milliseconds = std::chrono::duration<double, std::milli>;
namespace fs = std::filesystem;

constexpr std::chrono::milliseconds kLook{10};
/// The silence after which a server ends a session.
constexpr std::chrono::milliseconds kWindow{100};
constexpr int kMostAttempts = 5;

/// The growth of a monotonic figure [ms] within the last kWindow.  Its first value does not count.
class Growth {
 public:
  double To(double total_ms) {
    const Clock::time_point now = Clock::now();
    past_.emplace_back(now, total_ms);
    // The first entry is the last one before the window, if any.
    while (past_.size() > 1 && past_[1].first <= now - kWindow) past_.pop_front();
    return total_ms - past_.front().second;
  }

 private:
  std::deque<std::pair<Clock::time_point, double>> past_;
};

/// Time that a thread has waited for a processor so far [ms].
double WaitedOf(const fs::path& task) {
  std::ifstream file(task / "schedstat");
  double ran_ns = 0.0, waited_ns = 0.0;
  file >> ran_ns >> waited_ns;
  return 1e-6 * waited_ns;
}

/// Time that the host has taken from each processor so far [ms].
std::vector<double> StolenByProcessor() {
  const double tick_ms = 1e3 / static_cast<double>(sysconf(_SC_CLK_TCK));
  std::vector<double> stolen;
  std::ifstream file("/proc/stat");
  for (std::string line; std::getline(file, line) && line.starts_with("cpu");) {
    std::istringstream words(line);
    std::string name;
    double user, nice, system, idle, io, irq, softirq, steal = 0.0;
    words >> name >> user >> nice >> system >> idle >> io >> irq >> softirq >> steal;
    if (name != "cpu") stolen.push_back(tick_ms * steal);
  }
  return stolen;
}

}  // namespace

StallWitness::StallWitness() : processes_{getpid()}, thread_([this] { Run(); }) {}

StallWitness::~StallWitness() {
  stop_ = true;
  thread_.join();
}

void StallWitness::Watch(pid_t process) {
  const std::lock_guard lock(mutex_);
  processes_.push_back(process);
}

void StallWitness::Run() {
  std::map<std::pair<pid_t, std::string>, Growth> waited;  // by process and thread
  std::vector<Growth> stolen(StolenByProcessor().size());
  Growth overslept;
  double overslept_ms = 0.0;
  const auto saw = [this](double ms) { longest_ms_ = std::max(longest_ms_.load(), ms); };
  while (!stop_) {
    const auto due = Clock::now() + kLook;
    std::this_thread::sleep_until(due);
    overslept_ms += Milliseconds(Clock::now() - due).count();
    saw(overslept.To(overslept_ms));
    const std::vector<double> stolen_ms = StolenByProcessor();
    for (std::size_t i = 0; i < std::min(stolen.size(), stolen_ms.size()); ++i) {
      saw(stolen[i].To(stolen_ms[i]));
    }
    std::vector<pid_t> processes;
    {
      const std::lock_guard lock(mutex_);
      processes = processes_;
    }
    for (const pid_t process : processes) {
      std::error_code gone;
      for (const fs::directory_entry& task :
           fs::directory_iterator("/proc/" + std::to_string(process) + "/task", gone)) {
        saw(waited[{process, task.path().filename()}].To(WaitedOf(task.path())));
      }
    }
  }
}

testing::AssertionResult Shown(const std::function<Attempt(StallWitness&)>& attempt,
                               double stall_ms) {
  for (int i = 1; i <= kMostAttempts; ++i) {
    StallWitness witness;
    const Attempt outcome = attempt(witness);
    if (outcome == Attempt::kShown) return testing::AssertionSuccess();
    if (outcome == Attempt::kFailed) return testing::AssertionFailure() << "attempt " << i;
    const double longest_ms = witness.longest_ms();
    std::printf("attempt %d was spoilt; the machine stood still for %.0f ms in 100\n", i,
                longest_ms);
    if (longest_ms < stall_ms) {
      return testing::AssertionFailure()
             << "attempt " << i << " was spoilt, though nothing waited longer than " << longest_ms
             << " ms for a processor within a tenth of a second";
    }
  }
  [] {
    GTEST_SKIP() << "the machine stood still in each of " << kMostAttempts
                 << " attempts, so nothing is shown";
  }();
  return testing::AssertionSuccess();
}

}  // namespace palpate::test
