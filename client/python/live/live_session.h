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

/// A tool's state as numpy holds it: a record of live.Session (client/python/palpate/live.pyi).
struct ToolRecord {
  double time_s;  ///< when it came, by the steady clock: Python's time.monotonic()
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
  std::uint32_t points;  ///< how many of `point` count
  double point[16][6];   ///< where, and the force on the tool
};

/// A sample of the loop.
struct WrenchRecord {
  double time_s;       ///< when it came
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
  dds::Transport transport = dds::Transport::kAuto;  ///< of wrenches, as the server's
  bool wrenches = false;  ///< reads the loop, too: a thousand samples a second and station
};

/// Hears what goes on at a server: tools' states, and wrenches where they are asked for.  A thread
/// of its own takes what comes, and keeps a minute of it.
/// Thread contract: any.
class LiveSession {
 public:
  /// Throws Error.
  explicit LiveSession(const LiveSessionOptions& options);
  ~LiveSession() { Close(); }
  LiveSession(const LiveSession&) = delete;
  LiveSession& operator=(const LiveSession&) = delete;

  /// All that came since the last call, oldest first; waits until there is something.
  /// Throws Silence where nothing comes within `patience_s`: why not, as far as is known.
  std::vector<ToolRecord> TakeTools(double patience_s, const WaitOrStop& wait);
  std::vector<WrenchRecord> TakeWrenches(const std::string& station, double patience_s,
                                         const WaitOrStop& wait);
  std::optional<ToolRecord> LatestTool(const std::string& station) const;
  std::optional<WrenchRecord> LatestWrench(const std::string& station) const;
  /// What the server last said of each station's session: PhaseName.
  std::map<std::string, std::string> phases() const;
  /// Records that nobody took in time.
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

  mutable std::mutex mutex_;  // guards what follows; no servo loop of any process waits for it
  std::map<std::string, Station> stations_;
  std::deque<ToolRecord> queue_;
  std::uint64_t dropped_ = 0;
  std::string error_;
  bool heard_ = false;

  struct Tap {
    std::uint64_t run = 0;
    dds::Reader<wire::Wrench> reader;
  };
  std::map<std::string, Tap> taps_;  // the thread's; their callbacks use what stands above
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace palpate
