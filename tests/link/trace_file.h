#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/math/pose.h"

namespace palpate::test {

/// A row of the file that `palpate-station --trace` writes (client/station/trace.h).
struct TraceRow {
  std::int64_t time_ns = 0;
  std::uint64_t tick = 0;
  std::uint64_t pose = 0;
  std::uint64_t reply = 0;  ///< 0 before the first
  double age_ms = 0.0;      ///< infinite before the first reply
  double silence_ms = 0.0;  ///< also
  Wrench wanted;
  Wrench applied;
  std::string limiter;

  /// Whether that stage acted.
  bool Limited(const std::string& stage) const;
};

/// Ignores an unfinished last line, as of a station that is still writing.  Throws Error if the
/// file cannot be read or is no trace.
std::vector<TraceRow> ReadTrace(const std::string& file);

}  // namespace palpate::test
