#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <thread>

#include "client/station/reply.h"
#include "client/station/station_core.h"
#include "client/station/trace.h"
#include "common/dds/endpoint.h"
#include "common/realtime/latest_mailbox.h"

namespace palpate {

/// The way to a server, for one run of a session.
struct PosePath {
  dds::Writer<wire::HapticPose> writer;
  CouplingSpring spring;
};

/// Runs a StationCore at its device's rate: in the device's own thread where the device has a clock
/// (Device::StartTicks), else in one of its own, by the absolute clock.  Rests until the first
/// path, so that a script begins when somebody listens; from then on the device is served whether
/// there is a path or not.  Poses go out a thousand times a second at most: ticks in between only
/// evaluate.
/// Thread contract: all methods in one thread, which is not the servo thread.
class ServoThread {
 public:
  static constexpr double kMostPoses_Hz = 1000.0;

  /// Inherits the caller's scheduling.  The core must outlive it, and is the thread's until Stop().
  /// @param snapshot_period_s  how often a snapshot is made.
  /// @param trace              gets every tick; null: none.  Must outlive it.
  ServoThread(StationCore& core, ReplyRing& replies, double snapshot_period_s,
              Trace* trace = nullptr);
  ~ServoThread();
  ServoThread(const ServoThread&) = delete;
  ServoThread& operator=(const ServoThread&) = delete;

  /// Sends poses there from the next tick on; null: nowhere.  Returns when the former path is no
  /// longer in use.
  void SetPath(PosePath* path);
  /// From now on forces are enabled while the device's first button is held, and only then.  It
  /// must have been seen up since the device last was in order: one that is stuck enables nothing.
  void EnableForcesByButton() { by_button_.store(true); }
  /// Forces ramp to zero and stay there; or ramp in again, where nothing else keeps them off.
  void Mute(bool on) { muted_.store(on, std::memory_order_relaxed); }
  /// Where a guide wants the hand to be; the newest counts.
  void SetAim(const GuideAim& aim) { aims_.Write(aim); }
  /// Counts from the next tick on (StationCore::RestartTotals); the missed ticks, too.
  void RestartTotals() { restart_totals_.store(true); }
  /// Begins to stop, without waiting for it: for who stops several at once.
  void BeginToStop();
  /// Takes the force out of the device, by the limiter's ramp, and ends the thread.
  void Stop();

  bool ReadSnapshot(StationSnapshot& snapshot) { return snapshots_.Read(snapshot); }
  /// When the pose of the newest reply was sampled [ns]; 0 before the first.
  std::int64_t newest_reply_ns() const { return newest_reply_ns_.load(std::memory_order_relaxed); }
  /// Ticks that did not take place because the thread woke, or the device called, more than one
  /// tick late.
  std::uint64_t missed_ticks() const { return missed_ticks_.load(std::memory_order_relaxed); }
  /// The newest pose that was sent; 0 before the first.  From any thread.
  std::uint64_t newest_sequence() const noexcept { return newest_sequence_.load(); }
  /// When the pose of that number was sampled [ns], by this process's steady clock; 0 where it has
  /// not been, or 4 s ago.  From any thread.
  std::int64_t sample_time_ns(std::uint64_t sequence) const noexcept;
  std::uint64_t ticks() const { return tick_edges_.load(std::memory_order_relaxed) / 2; }
  bool started() const { return started_.load(std::memory_order_relaxed); }

 private:
  void Run() noexcept;
  void AwaitDevice() noexcept;
  void TickOfDevice() noexcept;
  void Tick(std::int64_t now_ns) noexcept;
  std::int64_t CountMissed(std::int64_t due_ns, std::int64_t now_ns) noexcept;
  bool IsTimeToSend() noexcept;
  void MindTheButton(const DeviceSample& sample) noexcept;
  /// Asked to stop, and the device has been told to render nothing.
  bool done() const noexcept { return done_.load(std::memory_order_acquire); }

  StationCore& core_;
  ReplyRing& replies_;
  Trace* const trace_;
  const double rate_Hz_;
  const std::int64_t tick_ns_;
  const std::uint64_t ticks_per_snapshot_;
  LatestMailbox<StationSnapshot> snapshots_;
  LatestMailbox<GuideAim> aims_;
  std::int64_t due_ns_ = 0;  // the next tick
  double poses_due_ = 0.0;
  bool button_ready_ = false;
  std::atomic<bool> by_button_{false};
  std::atomic<bool> muted_{false};
  std::atomic<bool> done_{false};
  std::atomic<PosePath*> path_{nullptr};
  std::atomic<bool> started_{false};
  std::atomic<bool> stop_{false};
  std::atomic<std::uint64_t> tick_edges_{0};  // begins and ends: odd while a tick runs
  std::atomic<std::uint64_t> missed_ticks_{0};
  std::atomic<std::int64_t> newest_reply_ns_{0};
  std::atomic<bool> restart_totals_{false};
  std::array<std::atomic<std::int64_t>, 4096> sample_times_ns_{};  // by sequence
  std::atomic<std::uint64_t> newest_sequence_{0};
  std::thread thread_;
};

}  // namespace palpate
