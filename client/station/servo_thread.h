#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <thread>

#include "client/station/reply_ring.h"
#include "client/station/station_core.h"
#include "client/station/trace.h"
#include "common/dds/endpoint.h"
#include "common/realtime/latest_mailbox.h"

namespace palpate {

/// The way to a server, for one run of a session.
struct PosePath {
  dds::Writer<wire::HapticPose> writer;
  Vec3 tool_reference = Vec3::Zero();  ///< in the tool's frame [m]
};

/// Runs a StationCore once a millisecond, by the absolute clock.  Rests until the first path, so
/// that a script begins when somebody listens; from then on the device is served whether there is a
/// path or not.
/// Thread contract: all methods in one thread, which is not the servo thread.
class ServoThread {
 public:
  static constexpr std::int64_t kTick_ns = 1'000'000;

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
  /// Ticks that did not take place because the thread woke more than one tick late.
  std::uint64_t missed_ticks() const { return missed_ticks_.load(std::memory_order_relaxed); }
  /// When the pose of that number was sampled [ns], by this process's steady clock; 0 where it has
  /// not been, or 4 s ago.  From any thread.
  std::int64_t sample_time_ns(std::uint64_t sequence) const noexcept;
  bool started() const { return started_.load(std::memory_order_relaxed); }

 private:
  void Run() noexcept;
  void AwaitTick() noexcept;
  void Tick() noexcept;

  StationCore& core_;
  ReplyRing& replies_;
  Trace* const trace_;
  const std::uint64_t ticks_per_snapshot_;
  LatestMailbox<StationSnapshot> snapshots_;
  LatestMailbox<GuideAim> aims_;
  std::int64_t next_ns_ = 0;
  std::atomic<PosePath*> path_{nullptr};
  std::atomic<bool> started_{false};
  std::atomic<bool> stop_{false};
  std::atomic<std::uint64_t> ticks_{0};
  std::atomic<std::uint64_t> missed_ticks_{0};
  std::atomic<std::int64_t> newest_reply_ns_{0};
  std::atomic<bool> restart_totals_{false};
  std::array<std::atomic<std::int64_t>, 4096> sample_times_ns_{};  // by sequence
  std::atomic<std::uint64_t> newest_sequence_{0};
  std::thread thread_;
};

}  // namespace palpate
