#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "client/replayer/export/column_file.h"
#include "common/dds/wire.h"

namespace palpate {

/// One station's session as tables with a row per sample; client/replayer/README.md lists their
/// columns. `time_s` is always the time at which the recorder received the sample, in seconds from
/// the recording's start.  Thread contract: one thread.
class SessionColumns {
 public:
  /// @param folder  of this session; it must exist.
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
  /// Writes the wrenches that still wait for their poses, and closes all tables.
  void Close();
  /// Returns the tables that have a row.  Call it after Close.
  std::vector<std::string> files();

 private:
  struct Waiting {
    wire::Wrench wrench;
    double time_s;
  };
  std::vector<ColumnFile*> tables();
  /// @param last  write all: no pose will come any more.
  void WriteAnswered(bool last);
  void Write(const Waiting& answer, double pose_s);

  ColumnFile poses_, wrenches_, faults_, tool_states_, contacts_, phases_, loop_, limiter_, guide_;
  std::map<std::uint64_t, double>
      pose_times_s_;             // by sequence; those that an answer may still need
  std::deque<Waiting> waiting_;  // wrenches that came before their poses
  std::int64_t first_sample_ns_ = 0;
  std::uint32_t faults_before_ = 0;
};

}  // namespace palpate
