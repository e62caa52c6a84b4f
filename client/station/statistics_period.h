#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "client/station/station_core.h"
#include "common/dds/wire.h"

namespace palpate {

/// Makes the station's statistics, once per second, from the snapshots that a display shows.
/// Thread contract: one thread, not the servo thread.
class StatisticsPeriod {
 public:
  static constexpr std::int64_t kPeriod_ns = 1'000'000'000;

  /// @param device  its model.
  StatisticsPeriod(const std::string& station, const std::string& device);

  /// Takes the next snapshot; returns the figures of a period at its end.
  /// @param missed_ticks  ServoThread::missed_ticks.   @param run  SessionLink::run.
  /// @param last          ends the period now, however short, so that all periods together cover
  ///                      the whole run.
  std::optional<wire::StationStatistics> Add(const StationSnapshot& snapshot,
                                             std::uint64_t missed_ticks, std::uint64_t run,
                                             bool last = false);

 private:
  wire::StationStatistics figures_{};  // of the period so far
  std::int64_t began_ns_ = 0;          // 0: no snapshot yet
  StationSnapshot before_;             // at the end of the last period
  std::uint64_t missed_before_ = 0;
};

}  // namespace palpate
