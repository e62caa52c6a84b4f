#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "client/station/served_tools.h"
#include "common/dds/endpoint.h"
#include "common/dds/participant.h"

namespace palpate {

/// A tool's state as a NumPy record of live.Session (client/python/palpate/live.pyi).
struct ToolRecord {
  double time_s;  ///< when it arrived, by the steady clock: Python's time.monotonic()
  char station[33];
  char scene[65];
  char tool_name[65];
  std::uint64_t pose_sequence;
  double hand[7];  ///< x y z w x y z, in W
  double tool[7];  ///< of the graphic tool
  double force_N[3];
  double torque_Nm[3];
  double step_time_s;
  std::uint32_t contacts;
  std::uint32_t faults;
  std::uint32_t points;  ///< number of valid entries of `point`
  double point[16][6];   ///< position, and force on the tool
};

/// An answer of the loop.
struct WrenchRecord {
  double time_s;       ///< when it arrived
  double pose_time_s;  ///< when the pose that it answers was sampled, by the station's steady clock
  std::uint64_t pose_sequence;
  std::uint32_t answer;
  double force_N[3];
  double torque_Nm[3];
  double tool[7];
  double step_time_s;
  std::uint32_t contacts;
  std::uint32_t faults;
};

struct LiveSessionOptions {
  int domain = 0;
  dds::Network network;
  dds::Transport transport = dds::Transport::kAuto;  ///< for wrenches, as the server's
  bool wrenches = false;  ///< also reads the loop: a thousand samples per second and station
};

/// Receives what a server publishes: tool states, and wrenches if asked for.  A thread of its own
/// receives the samples and keeps a minute of them.
/// Thread contract: any.
class LiveSession {
 public:
  /// Throws Error.
  explicit LiveSession(const LiveSessionOptions& options);
  ~LiveSession() { Close(); }
  LiveSession(const LiveSession&) = delete;
  LiveSession& operator=(const LiveSession&) = delete;

  /// Returns all that came since the last call, oldest first; waits for at least one.  Throws
  /// Silence with the likely reason if nothing comes within `patience_s`.
  std::vector<ToolRecord> TakeTools(double patience_s, const WaitOrStop& wait);
  std::vector<WrenchRecord> TakeWrenches(const std::string& station, double patience_s,
                                         const WaitOrStop& wait);
  std::optional<ToolRecord> LatestTool(const std::string& station) const;
  std::optional<WrenchRecord> LatestWrench(const std::string& station) const;
  /// Returns the phase of each station's session that the server last reported (PhaseName).
  std::map<std::string, std::string> phases() const;
  /// Returns the number of records that were dropped because nobody took them in time.
  std::uint64_t dropped() const;
  void Close();

 private:
  struct Station {
    std::string phase;
    std::uint64_t run = 0;
    bool over = false;
    std::optional<ToolRecord> latest_tool;
    std::deque<WrenchRecord> wrenches;
    std::optional<WrenchRecord> latest_wrench;
  };
  void Run();
  void OpenWrenches();
  template <class Record, class QueueOf, class Why>
  std::vector<Record> Take(double patience_s, const WaitOrStop& wait, QueueOf queue_of, Why why);
  const Station* Find(const std::string& station) const;
  std::string WhySilent() const;

  const LiveSessionOptions options_;
  dds::Participant service_;
  std::optional<dds::Participant> loop_;
  dds::Reader<wire::SessionState> states_;
  dds::Reader<wire::ToolState> tools_;

  mutable std::mutex mutex_;  // guards the members below; no process's servo loop waits for it
  std::map<std::string, Station> stations_;
  std::deque<ToolRecord> queue_;
  std::uint64_t dropped_ = 0;
  std::string error_;
  bool heard_ = false;

  struct Tap {
    std::uint64_t run = 0;
    dds::Reader<wire::Wrench> reader;
  };
  // Used by the thread only; their callbacks use the members above.
  std::map<std::string, Tap> taps_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace palpate
