#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "client/replayer/export/column_file.h"
#include "common/dds/wire.h"

namespace palpate {

/// One station's session as tables, a row for each sample; client/replayer/README.md names their
/// columns. `time_s` is everywhere when the recorder had the sample, in seconds from the
/// recording's start. Thread contract: one thread.
class SessionColumns {
 public:
  /// @param folder  of this session; it is there.
  SessionColumns(const std::string& folder, ColumnFormat format);

  void Add(const wire::HapticPose& pose, double time_s);
  void Add(const wire::Wrench& wrench, double time_s);
  void Add(const wire::ToolState& tool, double time_s);
  void Add(const wire::SessionState& state, double time_s);
  void Add(const wire::LoopStatistics& loop, double time_s);
  void Add(const wire::StationStatistics& station, double time_s);
  void Add(const wire::GuideTarget& guide, double time_s);

  std::size_t pending();
  void Flush();
  /// Writes what still waits for its pose, and closes all tables.
  void Close();
  /// Those of the tables that have a row, once it is closed.
  std::vector<std::string> files();

 private:
  struct Waiting {
    wire::Wrench wrench;
    double time_s;
  };
  std::vector<ColumnFile*> tables();
  /// @param last  none is waited for any longer.
  void WriteAnswered(bool last);
  void Write(const Waiting& answer, double pose_s);

  ColumnFile poses_, wrenches_, faults_, tool_states_, contacts_, phases_, loop_, limiter_, guide_;
  std::map<std::uint64_t, double>
      pose_times_s_;             // by sequence; those that an answer may still want
  std::deque<Waiting> waiting_;  // came before their poses
  std::int64_t first_sample_ns_ = 0;
  std::uint32_t faults_before_ = 0;
};

}  // namespace palpate
