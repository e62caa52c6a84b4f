#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/dds/wire.h"

namespace palpate {

/// What took place at a server, for those who look into a night afterwards: an object a line,
/// appended to a file.  Of one kind and station at most one event a second is written, and of one
/// kind at most 20; what was left out is counted in the next line ("left_out").  A file that takes
/// no more is told once, and again when it does.
/// Thread contract: one thread, which is none of the servo loops.
class EventLog {
 public:
  using Fields = std::vector<std::pair<const char*, std::string>>;

  static constexpr std::int64_t kApart_ns = 1'000'000'000;
  static constexpr int kMostOfAKind = 20;  ///< in that time

  /// Throws Error where the file cannot be appended to.
  explicit EventLog(const std::string& file);
  ~EventLog();
  EventLog(const EventLog&) = delete;
  EventLog& operator=(const EventLog&) = delete;

  /// {"time":"...","event":"start","domain":"0",...}; the destructor then writes a "stop".
  void OnStart(const Fields& fields);
  /// Events "held", "begun", "active", "acquiring", "muted", "unmuted", "ended", "refused": what is
  /// said again is none.
  void OnSession(const wire::SessionState& state, std::int64_t now_ns);
  /// Refusals that nobody was told of: left out here, too.
  void OnUntold(std::uint64_t count) { left_out_ += count; }
  /// "whole", "bookmark" or "back", or "refused" to do so.
  void OnWhole(const wire::SceneWhole& whole, std::int64_t now_ns);
  /// "fault", for bits that the station did not have the second before.  That a hand is quicker
  /// than its tool, or a tool has only come, is none.
  void OnStatistics(const wire::LoopStatistics& statistics, std::int64_t now_ns);

 private:
  /// Writes it unless there were too many.
  void Tell(const char* event, const std::string& station, const Fields& fields,
            std::int64_t now_ns);
  void Write(const char* event, const Fields& fields);
  bool Append(const std::string& line);

  std::string file_;
  int fd_ = -1;
  struct Session {
    std::uint64_t run;
    wire::SessionPhase phase;
    bool muted;
    friend bool operator==(const Session&, const Session&) = default;
  };
  std::map<std::string, Session> sessions_;      // by station
  std::map<std::string, std::uint32_t> faults_;  // of the second before, by station
  std::map<std::pair<std::string, std::string>, std::int64_t> told_;  // by event and station
  struct Budget {
    std::int64_t since_ns = 0;
    int written = 0;
  };
  std::map<std::string, Budget> budgets_;  // by event
  std::uint64_t left_out_ = 0;
  bool started_ = false, failing_ = false;
};

}  // namespace palpate
