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

/// A tenth of an ordinary thread's weight on the same core: any thread that wakes preempts this
/// one, yet it does not starve on a busy host, as it would with SCHED_IDLE.
constexpr int kNice = 10;

/// Returns the processor time of this thread: others often preempt it, which must not count.
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
  // On Linux this affects this thread alone, and lowering needs no rights.
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
    // At most tens of milliseconds, because the destructor waits for it.
    std::this_thread::sleep_for(std::chrono::nanoseconds(budget.WaitForTime(now_ns)));
  }
}

}  // namespace palpate
