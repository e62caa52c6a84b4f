#pragma once

#include <string>

#include "client/station/station_core.h"

namespace palpate {

/// A station's run, at its end.
struct StationSummary {
  std::string station, device, scene, tool, transport;
  double seconds = 0.0;
  double linked_ticks_s = 0.0;  ///< time that the loop ran [s]: ticks and those it missed
  StationTotals totals;
  std::uint64_t missed_ticks = 0;
  int reconnects = 0;
  WrenchLimits::Bounds limits;  ///< torque zero where the device renders none
  StationSnapshot end;          ///< the last moment
};

/// For people.
std::string ToText(const StationSummary& summary);
/// For programs: one JSON object; percentile groups as in palpate-bench.
std::string ToJson(const StationSummary& summary);
/// Writes the JSON to a file, or to stdout for "-".  Throws Error.
void WriteJson(const StationSummary& summary, const std::string& file);

}  // namespace palpate
