#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "client/load/process_use.h"
#include "client/station/station_core.h"
#include "common/realtime/histogram.h"

namespace palpate {

/// What all stations of a run have seen, together and the worst of them.
struct StationSum {
  std::uint64_t due = 0;      ///< poses that should have been sent: one a millisecond and station
  std::uint64_t on_time = 0;  ///< answered within a millisecond
  std::uint64_t answered = 0;
  std::uint64_t missed_ticks = 0;
  std::uint64_t reconnects = 0;
  double worst_late_fraction = 0.0;
  double worst_hz = 0.0;  ///< answered
  std::uint32_t faults = 0;
  Histogram round_trip;  ///< [ns]
  Histogram server_step;

  void Add(const StationTotals& totals, std::uint64_t missed, int reconnected);
  double late_fraction() const;
  double hz() const;  ///< answered, mean of the stations

 private:
  std::size_t stations_ = 0;
};

/// A run's result.
struct LoadFigures {
  std::size_t stations = 0;
  std::size_t viewers = 0;  ///< over WebSocket
  std::size_t stalled = 0;
  std::size_t dds_viewers = 0;
  double seconds = 0.0;
  double rate_hz = 0.0;  ///< of each station's frames at a viewer
  std::string transport;
  std::string load_averages;  ///< before it
  StationSum sum;
  std::optional<ProcessUse> server, gateway;  ///< nothing: its process is not known
  ProcessUse self;
  double machine_busy = 0.0;  ///< of all cores
  std::uint64_t viewer_frames = 0;
  std::uint64_t frames_due = 0;  ///< of our own stations; viewer_frames counts others', too
  std::uint64_t lost = 0;        ///< of those that were due
  std::size_t viewers_gone = 0;
  Histogram frame_age;
  std::uint64_t dds_frames = 0;
  std::uint64_t dds_frames_due = 0;
  std::uint64_t dds_lost = 0;
  Histogram dds_frame_age;

  double lost_fraction() const;
};

/// Under 1 % of the poses late, under 1 % of the frames lost, no viewer gone.
bool Holds(const LoadFigures& figures);

/// For people: "holds", or "does not hold, because" and each of those that it breaks.
std::string VerdictText(const LoadFigures& figures);

/// The resource that sets the limit, where a run does not hold: a process's thread that fills a
/// core, or the cores together, and who uses them; or neither.
std::string LimitingResource(const LoadFigures& figures, int cores);

/// For people; ends with the verdict.
std::string ToText(const LoadFigures& figures);
/// For programs: one JSON object; percentile groups as in palpate-bench.
std::string ToJson(const LoadFigures& figures);

}  // namespace palpate
