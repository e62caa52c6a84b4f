#include "server/transport/background_servo.h"

#include <chrono>
#include <utility>

#include <sys/resource.h>
#include <time.h>
#include <unistd.h>

#include "common/realtime/steady_clock.h"
#include "server/transport/servo_budget.h"

namespace palpate {
namespace {

/// A tenth of an ordinary thread's weight where both want the same core: any thread that wakes goes
/// before this one, and yet it is not starved on a busy host, as SCHED_IDLE would be.
constexpr int kNice = 10;

/// That this thread has had: it is often held up by others, which is not its doing.
std::int64_t CpuNanoseconds() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return time.tv_sec * std::int64_t{1'000'000'000} + time.tv_nsec;
}

}  // namespace

BackgroundServo::BackgroundServo(std::function<void(const wire::HapticPose&)> answer)
    : answer_(std::move(answer)), thread_([this] { Run(); }) {}

BackgroundServo::~BackgroundServo() {
  stop_.store(true);
  given_.fetch_add(1);
  given_.notify_one();
  thread_.join();
}

void BackgroundServo::Give(const wire::HapticPose& pose) noexcept {
  poses_.Write(pose);
  given_.fetch_add(1);
  given_.notify_one();
}

void BackgroundServo::Run() {
  // Of this thread alone, as Linux has it; whoever may do nothing may do this.
  setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);
  ServoBudget budget(kShare);
  wire::HapticPose pose{};
  for (;;) {
    const std::uint32_t given = given_.load();
    if (stop_.load()) return;
    if (!poses_.Read(pose)) {
      given_.wait(given);
      continue;
    }
    const std::int64_t begun_ns = CpuNanoseconds();
    answer_(pose);
    const std::int64_t now_ns = SteadyNanoseconds();
    budget.Took(CpuNanoseconds() - begun_ns, now_ns);
    // At most tens of milliseconds: who ends this waits for it.
    std::this_thread::sleep_for(std::chrono::nanoseconds(budget.WaitForTime(now_ns)));
  }
}

}  // namespace palpate
