#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "client/station/station_core.h"
#include "common/realtime/histogram.h"

namespace palpate {

/// The figures of all stations of a run: sums, and the worst station.
struct StationSum {
  std::uint64_t due = 0;      ///< poses that should have been sent: one per millisecond and station
  std::uint64_t on_time = 0;  ///< answered within a millisecond
  std::uint64_t answered = 0;
  std::uint64_t missed_ticks = 0;
  std::uint64_t reconnects = 0;
  double worst_late_fraction = 0.0;
  double worst_hz = 0.0;  ///< of answered poses
  std::uint32_t faults = 0;
  Histogram round_trip;  ///< [ns]
  Histogram server_step;

  void Add(const StationTotals& totals, std::uint64_t missed, int reconnected);
  double late_fraction() const;
  double hz() const;  ///< answered poses per second, mean of the stations

 private:
  std::size_t stations_ = 0;
};

/// The result of a run.
struct LoadFigures {
  std::size_t stations = 0;
  std::size_t viewers = 0;  ///< over WebSocket
  double seconds = 0.0;
  std::string transport;
  std::string load_averages;  ///< before the run
  StationSum sum;
  // Processor use, in fractions of one core; nothing: the process is not known.
  std::optional<double> server, gateway;
  double self = 0.0;
  double machine_busy = 0.0;  ///< fraction, of all cores
  std::uint64_t viewer_frames = 0;
  std::uint64_t frames_due = 0;  ///< from our own stations; viewer_frames also counts others
  std::uint64_t lost = 0;        ///< of the frames that were due
  std::size_t viewers_gone = 0;
  Histogram frame_age;

  double lost_fraction() const;
};

/// Returns whether under 1 % of the poses were late, under 1 % of the frames were lost, and no
/// viewer disconnected.
bool Holds(const LoadFigures& figures);

/// Returns the verdict for people: "holds", or "does not hold, because" and each criterion that
/// it fails.
std::string VerdictText(const LoadFigures& figures);

/// Returns the figures for people, ending with the verdict.
std::string ToText(const LoadFigures& figures);
/// Returns the figures for programs: one JSON object; percentile groups as in palpate-bench.
std::string ToJson(const LoadFigures& figures);

}  // namespace palpate
