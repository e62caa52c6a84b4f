#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <thread>

#include "client/station/reply.h"
#include "client/station/station_core.h"
#include "client/station/trace.h"
#include "common/dds/endpoint.h"
#include "common/program/stop_signal.h"
#include "common/realtime/latest_mailbox.h"

namespace palpate {

/// The connection to a server for one run of a session.
struct PosePath {
  dds::Writer<wire::HapticPose> writer;
  CouplingSpring spring;
};

/// Runs a StationCore at its device's rate: in the device's own thread if the device has a clock
/// (Device::StartTicks), otherwise in a thread of its own, timed by the absolute clock.  It waits
/// for the first path, so that a script begins when a server listens; after that it serves the
/// device with or without a path.  It sends at most a thousand poses per second: ticks in between
/// only evaluate.
/// Thread contract: all methods in one thread, which is not the servo thread.
class ServoThread {
 public:
  static constexpr double kMostPoses_Hz = 1000.0;

  /// Inherits the caller's scheduling.  The core must outlive it, and belongs to the thread
  /// until Stop().
  /// @param snapshot_period_s  how often a snapshot is made, however slow the loop is; at most as
  ///                           often as ReadSnapshot is called.
  /// @param trace              gets every tick; null: none.  Must outlive it.
  ServoThread(StationCore& core, ReplyRing& replies, double snapshot_period_s,
              Trace* trace = nullptr);
  ~ServoThread();
  ServoThread(const ServoThread&) = delete;
  ServoThread& operator=(const ServoThread&) = delete;

  /// Sends poses on that path from the next tick on; null: sends none.  Returns when the former
  /// path is no longer in use.
  void SetPath(PosePath* path);
  /// From now on, enables forces only while the device's first button is held.  The button must
  /// have been seen released since the device last was in order, so a stuck button enables nothing.
  void EnableForcesByButton() { by_button_.store(true); }
  /// Mutes forces, by a ramp to zero; or unmutes them, and they ramp in unless something else
  /// disables them.
  void Mute(bool on) { muted_.store(on, std::memory_order_relaxed); }
  /// From now on, takes the force out of the device as soon as a signal has come, even if the
  /// caller's thread hangs: in an output that nobody reads, on a disk.
  void LoseForceBy(const StopSignal& signal) { signal_.store(&signal); }
  /// Sets the guide's aim; the newest one counts.
  void SetAim(const GuideAim& aim) { aims_.Write(aim); }
  /// Restarts all counts at the next tick (StationCore::RestartTotals), including the missed ticks.
  void RestartTotals() { restart_totals_.store(true); }
  /// Begins to stop without waiting, so that a caller can stop several at once.
  void BeginToStop();
  /// Ramps the device's force to zero through the limiter, and ends the thread.
  void Stop();

  /// True once asked to stop and the device has been told to render nothing.
  bool done() const noexcept { return done_.load(std::memory_order_acquire); }

  bool ReadSnapshot(StationSnapshot& snapshot);
  /// Returns when the pose of the newest reply was sampled [ns]; 0 before the first.
  std::int64_t newest_reply_ns() const { return newest_reply_ns_.load(std::memory_order_relaxed); }
  /// Returns the number of ticks skipped because the thread woke, or the device called, more than
  /// one tick late.
  std::uint64_t missed_ticks() const { return missed_ticks_.load(std::memory_order_relaxed); }
  /// Returns the sequence number of the newest pose sent; 0 before the first.  From any thread.
  std::uint64_t newest_sequence() const noexcept { return newest_sequence_.load(); }
  /// Returns when the pose of that sequence number was sampled [ns], by this process's steady
  /// clock; 0 if it has not been sent, or was sent more than 4 s ago.  From any thread.
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

  StationCore& core_;
  ReplyRing& replies_;
  Trace* const trace_;
  const double rate_Hz_;
  const std::int64_t tick_ns_;
  const std::int64_t snapshot_period_ns_;
  std::int64_t snapshot_asked_ns_ = 0;  // of the caller's thread
  std::atomic<bool> snapshot_due_{false};
  LatestMailbox<StationSnapshot> snapshots_;
  LatestMailbox<GuideAim> aims_;
  std::int64_t due_ns_ = 0;  // of the next tick
  double poses_due_ = 0.0;
  bool button_ready_ = false;
  std::atomic<bool> by_button_{false};
  std::atomic<bool> muted_{false};
  std::atomic<bool> done_{false};
  std::atomic<PosePath*> path_{nullptr};
  std::atomic<bool> started_{false};
  std::atomic<bool> stop_{false};
  std::atomic<const StopSignal*> signal_{nullptr};
  std::atomic<std::uint64_t> tick_edges_{0};  // starts plus ends of ticks: odd while a tick runs
  std::atomic<std::uint64_t> missed_ticks_{0};
  std::atomic<std::int64_t> newest_reply_ns_{0};
  std::atomic<bool> restart_totals_{false};
  std::array<std::atomic<std::int64_t>, 4096> sample_times_ns_{};  // by sequence
  std::atomic<std::uint64_t> newest_sequence_{0};
  std::thread thread_;
};

}  // namespace palpate
