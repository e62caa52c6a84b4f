#pragma once

#include <atomic>
#include <cstdint>
#include <cstdio>
#include <string>
#include <thread>

#include "client/station/station_core.h"
#include "common/realtime/ring.h"

namespace palpate {

/// The inputs and outputs of one tick of the servo loop.
struct TickRecord {
  std::int64_t time_ns = 0;             ///< of the tick, by the station's steady clock
  std::uint64_t pose_sequence = 0;      ///< of the newest pose that was sent
  std::uint64_t reply_sequence = 0;     ///< of the newest reply that was used; 0 before the first
  std::int64_t reply_pose_time_ns = 0;  ///< when its pose was sampled
  std::int64_t reply_received_ns = 0;   ///< when that reply arrived
  Wrench wanted;                        ///< at the handle, in W: the limiter's input
  Wrench applied;                       ///< the limiter's output
  LimiterCounts limiter;                ///< since the station began
};

/// Writes every tick of a station to a CSV file, one row per tick, from which the safety figures
/// are computed.  Columns, with vectors in W:
///   time_ns          of the tick, steady clock
///   tick             from 1; a gap means dropped rows
///   pose, reply      sequence of the newest pose sent and of the newest reply used
///   age_ms           since that reply's pose was sampled; empty before the first reply
///   silence_ms       since that reply came; empty before the first reply
///   wanted_fx_N ...  wrench that the limiter was asked for, at the handle
///   applied_fx_N ... wrench that the device was given
///   limiter          its stages that acted since the previous row, as in `slew+age`
/// A separate thread writes.  It inherits the scheduling of the thread that made it, which must not
/// be real-time.  The queue between the two holds kRoom ticks: those that do not fit are dropped
/// and counted.
/// Thread contract: Add in the servo thread, all else in one other.
class Trace {
 public:
  static constexpr std::size_t kRoom = 8192;  ///< 8 s at 1 kHz, 2 s at 4 kHz

  /// Throws Error if the file cannot be created.
  explicit Trace(std::string file);
  /// Closes the file, and ignores errors.
  ~Trace();
  Trace(const Trace&) = delete;
  Trace& operator=(const Trace&) = delete;

  /// Adds a tick.  Real-time: wait-free.
  void Add(const TickRecord& record) noexcept;
  /// Writes the remaining rows; no Add may follow.  Throws Error if the disk did not take all rows.
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
  LimiterCounts before_;  // of the previous row
  std::thread thread_;
};

}  // namespace palpate
