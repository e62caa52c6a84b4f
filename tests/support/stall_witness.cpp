#include "tests/support/stall_witness.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
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
constexpr int kMostAttempts = 5;

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
  // By process and thread.  What a thread had waited when it was first seen is not this witness's.
  std::map<std::pair<pid_t, std::string>, double> waited_ms;
  std::vector<double> stolen_ms = StolenByProcessor();
  const auto saw = [this](double ms) { longest_ms_ = std::max(longest_ms_.load(), ms); };
  while (!stop_) {
    const auto due = Clock::now() + kLook;
    std::this_thread::sleep_until(due);
    saw(Milliseconds(Clock::now() - due).count());
    const std::vector<double> stolen_now_ms = StolenByProcessor();
    for (std::size_t i = 0; i < std::min(stolen_ms.size(), stolen_now_ms.size()); ++i) {
      saw(stolen_now_ms[i] - stolen_ms[i]);
    }
    stolen_ms = stolen_now_ms;
    std::vector<pid_t> processes;
    {
      const std::lock_guard lock(mutex_);
      processes = processes_;
    }
    for (const pid_t process : processes) {
      std::error_code gone;
      for (const fs::directory_entry& task :
           fs::directory_iterator("/proc/" + std::to_string(process) + "/task", gone)) {
        const double now_ms = WaitedOf(task.path());
        const auto [known, is_new] =
            waited_ms.try_emplace({process, task.path().filename()}, now_ms);
        saw(now_ms - std::exchange(known->second, now_ms));
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
    std::printf("attempt %d was spoilt; the machine stood still for %.0f ms\n", i, longest_ms);
    if (longest_ms < stall_ms) {
      return testing::AssertionFailure()
             << "attempt " << i << " was spoilt, though nothing waited for a processor longer than "
             << longest_ms << " ms";
    }
  }
  return testing::AssertionFailure() << "the machine stood still in each of " << kMostAttempts
                                     << " attempts, so nothing is shown";
}

}  // namespace palpate::test
