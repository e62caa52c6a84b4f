#include "devices/plugin/plugin_device.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include <pthread.h>

#include "common/realtime/sleep_until.h"
#include "common/realtime/steady_clock.h"
#include "devices/wrench_limiter.h"

namespace palpate {
namespace {

/// Who watches a loop that may spin comes before it.
void ComeBeforeTheLoop() noexcept {
  int policy = 0;
  sched_param parameters{};
  pthread_getschedparam(pthread_self(), &policy, &parameters);
  if (policy != SCHED_FIFO) return;
  ++parameters.sched_priority;
  pthread_setschedparam(pthread_self(), policy, &parameters);
}

}  // namespace

PluginDevice::PluginDevice(const DeviceOptions& options)
    : arm_(std::make_shared<plugin::PluginArm>(options)) {}

void PluginDevice::Apply(const LimitedWrench& wrench) noexcept {
  arm_->wanted = wrench.wrench();
}

void PluginDevice::Loop::Run() noexcept {
  const auto tick_ns = static_cast<std::int64_t>(1e9 / arm->info.rate_Hz);
  std::int64_t due_ns = SteadyNanoseconds();
  while (arm->Turn(tick)) {
    // Held up: goes on from here, without a burst.
    due_ns = std::max(due_ns + tick_ns, SteadyNanoseconds());
    SleepUntil(due_ns);
  }
  ended = true;
}

void PluginDevice::Loop::Watch() noexcept {
  ComeBeforeTheLoop();
  while (watched) {
    arm->Watch(SteadyNanoseconds());
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

bool PluginDevice::StartTicks(std::function<void()> tick) {
  arm_->Begin();
  loop_ = std::make_shared<Loop>();
  loop_->arm = arm_;
  loop_->tick = std::move(tick);
  turns_ = std::thread([loop = loop_] { loop->Run(); });
  watch_ = std::thread([loop = loop_] { loop->Watch(); });
  return true;
}

void PluginDevice::StopTicks() {
  if (!turns_.joinable()) return;
  arm_->Leave();
  constexpr int kPatience_ms = 500;
  for (int ms = 0; ms < kPatience_ms && !loop_->ended; ++ms) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  if (loop_->ended) {
    turns_.join();
  } else {
    turns_.detach();
  }
  loop_->watched = false;
  watch_.join();
  arm_->Stop();
}

DeviceKind PluginKind() {
  return {.name = "./DRIVER.so",
          .what = "an arm of your own, by a driver that you have built: devices/arm.md",
          .max_rate_Hz = 4000.0,
          .is_file = true,
          .check_host = [](const std::string& name) { plugin::LoadDriver(name); },
          .make = [](const DeviceOptions& options) -> std::unique_ptr<Device> {
            return std::make_unique<PluginDevice>(options);
          }};
}

}  // namespace palpate
