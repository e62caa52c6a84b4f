#include "client/station/servo_thread.h"

#include <algorithm>
#include <chrono>

#include <time.h>

#include "common/time/steady_clock.h"

namespace palpate {
namespace {

void SleepUntil(std::int64_t time_ns) noexcept {
  timespec at{};
  at.tv_sec = time_ns / 1'000'000'000;
  at.tv_nsec = time_ns % 1'000'000'000;
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr) != 0) {
  }
}

wire::HapticPose ToWire(const OutgoingPose& pose) noexcept {
  wire::HapticPose sample{};
  sample.pose_sequence = pose.sequence;
  sample.sample_time_ns = pose.sample_time_ns;
  wire::FromPose(pose.sample.X_WH, sample.position_m, sample.orientation_wxyz);
  wire::FromVec3(pose.sample.V_WH.v, sample.linear_velocity_m_s);
  wire::FromVec3(pose.sample.V_WH.w, sample.angular_velocity_rad_s);
  sample.buttons = pose.sample.buttons;
  sample.device_status = pose.sample.status;
  return sample;
}

TickRecord RecordOf(const StationCore& core, std::int64_t now_ns) noexcept {
  const Reply& reply = core.newest();
  return {
      now_ns,        core.sequence(), reply.pose_sequence,    reply.pose_time_ns, reply.received_ns,
      core.wanted(), core.applied(),  core.limiter().counts()};
}

}  // namespace

ServoThread::ServoThread(StationCore& core, ReplyRing& replies, double snapshot_period_s,
                         Trace* trace)
    : core_(core),
      replies_(replies),
      trace_(trace),
      ticks_per_snapshot_(static_cast<std::uint64_t>(std::max(1.0, snapshot_period_s * 1e3))),
      thread_([this] { Run(); }) {}

ServoThread::~ServoThread() {
  Stop();
}

void ServoThread::BeginToStop() {
  stop_.store(true);
  started_.store(true);
  started_.notify_one();
}

void ServoThread::Stop() {
  if (!thread_.joinable()) return;
  BeginToStop();
  thread_.join();
}

std::int64_t ServoThread::sample_time_ns(std::uint64_t sequence) const noexcept {
  // Acquire: the time of the newest pose is written.
  const std::uint64_t newest = newest_sequence_.load(std::memory_order_acquire);
  // One short: the oldest may just be giving way to the next.
  if (sequence > newest || newest - sequence >= sample_times_ns_.size() - 1) return 0;
  return sample_times_ns_[sequence % sample_times_ns_.size()].load(std::memory_order_relaxed);
}

void ServoThread::SetPath(PosePath* path) {
  const bool replaced = path_.exchange(path) != nullptr;
  if (path != nullptr && !started_.exchange(true)) started_.notify_one();
  if (!replaced || !thread_.joinable()) return;
  // The tick that runs now may still hold the former path; the one after the next does not.
  const std::uint64_t quiet = ticks_.load() + 2;
  while (ticks_.load() < quiet) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

void ServoThread::AwaitTick() noexcept {
  next_ns_ += kTick_ns;
  SleepUntil(next_ns_);
  const std::int64_t late_ns = SteadyNanoseconds() - next_ns_;
  if (late_ns <= kTick_ns) return;
  // Held up: goes on from here, without a burst.
  const std::int64_t missed = late_ns / kTick_ns;
  missed_ticks_.fetch_add(static_cast<std::uint64_t>(missed), std::memory_order_relaxed);
  next_ns_ += missed * kTick_ns;
}

void ServoThread::Tick() noexcept {
  const std::int64_t now_ns = SteadyNanoseconds();
  if (restart_totals_.exchange(false)) {
    core_.RestartTotals();
    missed_ticks_.store(0, std::memory_order_relaxed);
  }
  PosePath* const path = path_.load(std::memory_order_acquire);
  const OutgoingPose pose = core_.Sense(now_ns, path != nullptr);
  if (path) {
    sample_times_ns_[pose.sequence % sample_times_ns_.size()].store(now_ns,
                                                                    std::memory_order_relaxed);
    newest_sequence_.store(pose.sequence, std::memory_order_release);
    core_.SetToolReference(path->tool_reference);
    path->writer.Write(ToWire(pose));  // where DDS refuses it, the pose is lost and counted as such
  }
  Reply reply;
  while (replies_.Pop(reply)) core_.Take(SteadyNanoseconds(), reply);
  GuideAim aim;
  if (aims_.Read(aim)) core_.Take(now_ns, aim);
  core_.Act(now_ns);
  if (trace_) trace_->Add(RecordOf(core_, now_ns));
  newest_reply_ns_.store(core_.newest_reply_ns(), std::memory_order_relaxed);
  const std::uint64_t ticks = ticks_.fetch_add(1, std::memory_order_release) + 1;
  if (ticks % ticks_per_snapshot_ == 0) snapshots_.Write(core_.TakeSnapshot(now_ns));
}

void ServoThread::Run() noexcept {
  started_.wait(false);
  next_ns_ = SteadyNanoseconds();
  while (!stop_.load(std::memory_order_relaxed)) {
    AwaitTick();
    Tick();
  }
  // A device keeps what it was told last: that is to be nothing.
  core_.EnableForces(false);
  while (core_.renders_force()) {
    AwaitTick();
    Tick();
  }
}

}  // namespace palpate
