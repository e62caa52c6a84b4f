#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "common/dds/wire.h"

namespace palpate {

/// A log of a server's events, for later analysis: one JSON object per line, appended to a file.
/// At most one event a second is written of each kind and station, and at most 20 of each kind; the
/// next line counts those left out ("left_out").  If the file cannot be written, that is reported
/// once, and again when it can.
/// Thread contract: one thread, not a servo loop's.
class EventLog {
 public:
  using Fields = std::vector<std::pair<const char*, std::string>>;

  static constexpr std::int64_t kApart_ns = 1'000'000'000;
  static constexpr int kMostOfAKind = 20;  ///< in kApart_ns

  /// Throws Error if the file cannot be appended to.
  explicit EventLog(const std::string& file);
  ~EventLog();
  EventLog(const EventLog&) = delete;
  EventLog& operator=(const EventLog&) = delete;

  /// Writes {"time":"...","event":"start","domain":"0",...}; the destructor writes a "stop".
  void OnStart(const Fields& fields);
  /// Writes "held", "begun", "active", "acquiring", "muted", "unmuted", "ended" or "refused"; a
  /// repeated state is not an event.
  void OnSession(const wire::SessionState& state, std::int64_t now_ns);
  /// Counts refusals that were not published; they are left out here, too.
  void OnUntold(std::uint64_t count) { left_out_ += count; }
  /// Writes "whole", "bookmark", "back" or, if that was refused, "refused".
  void OnWhole(const wire::SceneWhole& whole, std::int64_t now_ns);
  /// Writes "fault" for fault bits that the station did not have in the second before.  A hand that
  /// is faster than its tool, or a tool that has just come, is not an event.
  void OnStatistics(const wire::LoopStatistics& statistics, std::int64_t now_ns);

 private:
  /// Writes an event unless there were too many.
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
  std::map<std::string, std::uint32_t> faults_;  // by station: faults of the second before
  std::map<std::pair<std::string, std::string>, std::int64_t> reported_;  // by event and station
  struct Budget {
    std::int64_t since_ns = 0;
    int written = 0;
  };
  std::map<std::string, Budget> budgets_;  // by event
  std::uint64_t left_out_ = 0;
  bool started_ = false, failing_ = false;
};

}  // namespace palpate
