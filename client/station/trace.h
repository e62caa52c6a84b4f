#pragma once

#include <atomic>
#include <cstdint>
#include <cstdio>
#include <string>
#include <thread>

#include "client/station/station_core.h"
#include "common/realtime/ring.h"

namespace palpate {

/// What one tick of the servo loop knew and did.
struct TickRecord {
  std::int64_t time_ns = 0;             ///< of the tick, by the station's steady clock
  std::uint64_t pose_sequence = 0;      ///< of the newest pose that was sent
  std::uint64_t reply_sequence = 0;     ///< of the newest reply that was used; 0 before the first
  std::int64_t reply_pose_time_ns = 0;  ///< when its pose was sampled
  std::int64_t reply_received_ns = 0;   ///< when it came
  Wrench wanted;                        ///< at the handle, in W: what the limiter was asked for
  Wrench applied;                       ///< what it let through
  LimiterCounts limiter;                ///< since the station began
};

/// Writes every tick of a station to a CSV file: a row a tick, from which the safety figures are
/// measured.  Columns, with vectors in W:
///   time_ns          of the tick, steady clock
///   tick             from 1; a gap is rows that were dropped
///   pose, reply      sequence of the newest pose sent and of the newest reply used
///   age_ms           since that reply's pose was sampled; empty before the first reply
///   silence_ms       since that reply came; empty before the first reply
///   wanted_fx_N ...  wrench that the limiter was asked for, at the handle
///   applied_fx_N ... wrench that the device was given
///   limiter          its stages that acted since the row before, as in `slew+age`
/// A thread of its own writes, with the scheduling of the one that made it; it is not to be
/// real-time.  Between the two is room for kRoom ticks: those that do not fit are dropped, counted.
/// Thread contract: Add in the servo thread, all else in one other.
class Trace {
 public:
  static constexpr std::size_t kRoom = 8192;  ///< 8 s at 1 kHz, 2 s at 4 kHz

  /// Throws Error where the file cannot be made.
  explicit Trace(std::string file);
  /// Closes, and keeps an error to itself.
  ~Trace();
  Trace(const Trace&) = delete;
  Trace& operator=(const Trace&) = delete;

  /// After a tick.  Real-time: wait-free.
  void Add(const TickRecord& record) noexcept;
  /// Writes what is left; nothing may be added any more.  Throws Error where the disk did not take
  /// all rows.
  void Close();
  std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

 private:
  void Run();
  void Drain();

  const std::string file_;
  std::FILE* out_;
  Ring<TickRecord, kRoom> records_;
  std::atomic<std::uint64_t> dropped_{0};
  std::atomic<bool> stop_{false};
  LimiterCounts before_;  // of the row before
  std::thread thread_;
};

}  // namespace palpate
