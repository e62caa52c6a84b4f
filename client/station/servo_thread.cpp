#include "client/station/servo_thread.h"

#include <algorithm>
#include <chrono>

#include "common/realtime/sleep_until.h"
#include "common/realtime/steady_clock.h"

namespace palpate {
namespace {

wire::HapticPose ToWire(const OutgoingPose& pose) noexcept {
  wire::HapticPose sample{};
  sample.pose_sequence = pose.sequence;
  sample.sample_time_ns = pose.sample_time_ns;
  wire::FromPose(pose.X_WH, sample.position_m, sample.orientation_wxyz);
  wire::FromVec3(pose.sample.V_WH.v, sample.linear_velocity_m_s);
  wire::FromVec3(pose.sample.V_WH.w, sample.angular_velocity_rad_s);
  sample.buttons = pose.sample.buttons;
  sample.device_status = pose.sample.status;
  return sample;
}

TickRecord RecordOf(const StationCore& core, std::int64_t now_ns) noexcept {
  const Reply& reply = core.newest();
  const LimiterInput& asked = core.asked();
  const Wrench wanted{asked.wanted.force + asked.led.force, asked.wanted.torque + asked.led.torque};
  return {now_ns, core.sequence(), reply.pose_sequence,    reply.pose_time_ns, reply.received_ns,
          wanted, core.applied(),  core.limiter().counts()};
}

}  // namespace

ServoThread::ServoThread(StationCore& core, ReplyRing& replies, double snapshot_period_s,
                         Trace* trace)
    : core_(core),
      replies_(replies),
      trace_(trace),
      rate_Hz_(core.device().info().rate_Hz),
      tick_ns_(static_cast<std::int64_t>(1e9 / rate_Hz_)),
      snapshot_period_ns_(static_cast<std::int64_t>(1e9 * snapshot_period_s)),
      thread_([this] { Run(); }) {}

ServoThread::~ServoThread() {
  Stop();
}

void ServoThread::BeginToStop() {
  stop_.store(true);
  stop_.notify_one();
  started_.store(true);
  started_.notify_one();
}

void ServoThread::Stop() {
  if (!thread_.joinable()) return;
  BeginToStop();
  thread_.join();
}

std::int64_t ServoThread::sample_time_ns(std::uint64_t sequence) const noexcept {
  // Acquire: makes the time of the newest pose visible.
  const std::uint64_t newest = newest_sequence_.load(std::memory_order_acquire);
  // One less, as the oldest entry may just be overwritten.
  if (sequence > newest || newest - sequence >= sample_times_ns_.size() - 1) return 0;
  return sample_times_ns_[sequence % sample_times_ns_.size()].load(std::memory_order_relaxed);
}

void ServoThread::SetPath(PosePath* path) {
  const bool replaced = path_.exchange(path) != nullptr;
  if (path != nullptr && !started_.exchange(true)) started_.notify_one();
  if (!replaced) return;
  // A tick that runs now may still use the former path; later ones do not.
  const std::uint64_t edges = tick_edges_.load();
  if (edges % 2 == 0) return;
  while (tick_edges_.load() == edges) std::this_thread::sleep_for(std::chrono::microseconds(100));
}

bool ServoThread::ReadSnapshot(StationSnapshot& snapshot) {
  // By this thread's clock, since a slow loop must be shown in time, and the loop branches on none.
  const std::int64_t now_ns = SteadyNanoseconds();
  if (ticks() == 0) {
    snapshot_asked_ns_ = now_ns;
  } else if (now_ns - snapshot_asked_ns_ >= snapshot_period_ns_) {
    snapshot_asked_ns_ =
        std::max(snapshot_asked_ns_ + snapshot_period_ns_, now_ns - snapshot_period_ns_);
    snapshot_due_ = true;
  }
  return snapshots_.Read(snapshot);
}

/// Returns how many ticks since `due_ns` did not take place.
std::int64_t ServoThread::CountMissed(std::int64_t due_ns, std::int64_t now_ns) noexcept {
  const std::int64_t missed = std::max<std::int64_t>(0, (now_ns - due_ns - 1) / tick_ns_);
  missed_ticks_.fetch_add(static_cast<std::uint64_t>(missed), std::memory_order_relaxed);
  return missed;
}

bool ServoThread::IsTimeToSend() noexcept {
  poses_due_ += kMostPoses_Hz / rate_Hz_;
  if (poses_due_ < 1.0) return false;
  // A slow device sends at each tick, without a backlog.
  poses_due_ = std::min(poses_due_ - 1.0, 1.0);
  return true;
}

void ServoThread::MindTheButton(const DeviceSample& sample) noexcept {
  const bool held = sample.buttons & 1u;
  if (sample.status & kDeviceFault) {
    button_ready_ = false;
  } else if (!held) {
    button_ready_ = true;
  }
  core_.EnableForces(button_ready_ && held);
}

void ServoThread::Tick(std::int64_t now_ns) noexcept {
  tick_edges_.fetch_add(1);
  if (restart_totals_.exchange(false)) {
    core_.RestartTotals();
    missed_ticks_.store(0, std::memory_order_relaxed);
  }
  PosePath* const path = path_.load();
  if (path == nullptr) core_.LoseSession();
  const bool sending = path != nullptr && IsTimeToSend();
  const OutgoingPose pose = core_.Sense(now_ns, sending);
  if (by_button_.load(std::memory_order_relaxed)) MindTheButton(pose.sample);
  core_.Mute(muted_.load(std::memory_order_relaxed));
  // A device keeps its last command, so that must be zero.
  const StopSignal* const signal = signal_.load(std::memory_order_relaxed);
  const bool stopping =
      stop_.load(std::memory_order_relaxed) || (signal != nullptr && signal->stopped());
  if (stopping) core_.EnableForces(false);
  if (sending) {
    sample_times_ns_[pose.sequence % sample_times_ns_.size()].store(now_ns,
                                                                    std::memory_order_relaxed);
    newest_sequence_.store(pose.sequence, std::memory_order_release);
    core_.SetSpring(path->spring);
    path->writer.Write(ToWire(pose));  // if DDS refuses it, it counts as lost
  }
  Reply reply;
  // At most as many as the ring holds, so that a flood of replies does not prolong the tick.
  for (std::size_t i = 0; i < ReplyRing::kCapacity && replies_.Pop(reply); ++i) core_.Take(reply);
  GuideAim aim;
  if (aims_.Read(aim)) core_.Take(now_ns, aim);
  core_.Act(now_ns);
  if (trace_) trace_->Add(RecordOf(core_, now_ns));
  newest_reply_ns_.store(core_.newest_reply_ns(), std::memory_order_relaxed);
  tick_edges_.fetch_add(1);
  if (snapshot_due_.exchange(false)) snapshots_.Write(core_.TakeSnapshot(now_ns));
  if (stopping && !core_.renders_force()) done_.store(true, std::memory_order_release);
}

void ServoThread::Run() noexcept {
  started_.wait(false);
  if (stop_.load()) return;
  due_ns_ = SteadyNanoseconds() + tick_ns_;
  if (core_.device().StartTicks([this] { TickOfDevice(); })) {
    AwaitDevice();
    core_.device().StopTicks();
    return;
  }
  while (!done()) {
    SleepUntil(due_ns_);
    const std::int64_t now_ns = SteadyNanoseconds();
    // After a delay, continues from here without a burst of ticks.
    due_ns_ += (1 + CountMissed(due_ns_, now_ns)) * tick_ns_;
    Tick(now_ns);
  }
}

void ServoThread::TickOfDevice() noexcept {
  const std::int64_t now_ns = SteadyNanoseconds();
  CountMissed(due_ns_, now_ns);
  due_ns_ = now_ns + tick_ns_;
  Tick(now_ns);
}

void ServoThread::AwaitDevice() noexcept {
  stop_.wait(false);
  // A dead device no longer ticks, and renders nothing.
  constexpr int kPatience_ms = 1000;
  std::uint64_t edges = tick_edges_.load();
  for (int silent_ms = 0; !done() && silent_ms < kPatience_ms; ++silent_ms) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (edges == tick_edges_.load()) continue;
    edges = tick_edges_.load();
    silent_ms = 0;
  }
}

}  // namespace palpate
