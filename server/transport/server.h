#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/dds/endpoint.h"
#include "common/realtime/token_bucket.h"
#include "server/offer/served_scene.h"
#include "server/session/session_table.h"
#include "server/transport/station_link.h"

namespace palpate {

/// Callbacks for those who record a server's events, called after it has published them: in the
/// thread that calls Poll, and in the destructor.  Any may be empty; none may throw.
struct ServerEvents {
  std::function<void(const wire::SessionState&)> session;
  std::function<void(std::uint64_t)> untold;  ///< refusals that were too many to be published
  std::function<void(const wire::SceneWhole&)> whole;
  std::function<void(const wire::LoopStatistics&)> statistics;  ///< per station and second
};

/// The server without its command line: takes requests, publishes states, and keeps a link for each
/// session; tool states go out at 60 Hz, statistics once a second.  All this happens in the one
/// thread that calls Poll, so nothing here needs a lock.  The servo loops run in DDS's receiving
/// threads and communicate only through mailboxes.
class Server {
 public:
  /// @param print_line  takes a line of text per station and second; may be empty
  /// @param admit_by_hand  stations wait until somebody admits them
  Server(dds::Participant loop_domain, dds::Participant service_domain,
         std::vector<std::shared_ptr<const ServedTool>> tools,
         std::function<void(const std::string&)> print_line, bool admit_by_hand = false);
  /// Ends every session and tells the stations.
  ~Server();
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;

  /// Publishes the scene to present and later viewers.
  /// @param bundle  the scene as PackScene makes it.  Throws Error if DDS refuses it.
  /// @param seats  further names under which the scene is served; these get its hash only
  void PublishScene(const std::string& name, std::vector<std::uint8_t> bundle,
                    const std::vector<std::string>& seats = {});

  /// Publishes to present and later stations what they can drive, and what a hand does there.  A
  /// second call replaces the first.  Throws Error if DDS refuses it.
  void Offer(const std::vector<ServedScene>& scenes);

  /// Whatever the callbacks use must outlive the server.
  void Observe(ServerEvents events) { events_ = std::move(events); }

  /// Call about every 5 ms.
  void Poll(std::int64_t now_ns);
  const SessionTable& table() const { return table_; }

 private:
  struct Station {
    std::unique_ptr<StationLink> link;
    std::int64_t reported_ns = 0;
    bool report_wanted = false;
    std::uint64_t refused = 0;  // of link->refused(), already reported
  };

  void TakeRequests(std::int64_t now_ns);
  /// Logs what others have asked for, at a limited rate because they may ask without end.
  void LogWish(std::int64_t now_ns, const std::string& line);
  void PublishChanges(std::int64_t now_ns);
  /// Disposes of the states of sessions that ended some time ago.
  void DisposeOfEnded(std::int64_t now_ns);
  void CheckSharedMemory(std::int64_t now_ns);
  void UpdateLinks(std::int64_t now_ns);
  void ForgetStreams(const std::string& station);
  void PublishToolState(Session& session);
  void PublishMoved(const Session& session);
  void ReportStatistics(Station& station, std::int64_t now_ns);
  /// Called each second, and at the end of the session, because a flood may be
  /// shorter than a second.
  void TellUnheard(const std::string& name, Station& station);

  dds::Participant loop_domain_;
  dds::Participant service_domain_;
  const std::uint64_t server_run_;
  SessionTable table_;
  std::function<void(const std::string&)> print_line_;
  ServerEvents events_;
  dds::Reader<wire::SessionRequest> requests_;
  dds::Writer<wire::SessionState> states_;
  dds::Writer<wire::SolidBlock> solid_blocks_;
  dds::Writer<wire::CutLog> cut_logs_;
  dds::Writer<wire::LoopWhole> loop_wholes_;
  dds::Reader<wire::WholeRequest> whole_requests_;
  dds::Reader<wire::OperateRequest> operate_requests_;
  dds::Writer<wire::SceneWhole> wholes_;
  dds::Writer<wire::SceneBundle> scene_bundles_;
  dds::Writer<wire::SceneOffer> offers_;
  dds::Writer<wire::ToolState> tool_states_;
  dds::Writer<wire::MovedState> moved_states_;
  dds::Writer<wire::LoopStatistics> statistics_;
  std::map<std::string, Station> stations_;
  std::map<std::string, std::int64_t> over_since_ns_;  // by station: since its refusal or end
  TokenBucket lines_{50.0, 400.0};                     // enough for a class that starts all at once
  std::uint64_t lines_left_out_ = 0;
  TokenBucket wishes_to_make_whole_{1.0, 5.0};
  std::int64_t untold_said_ns_ = 0;
  std::uint64_t untold_ = 0;
  std::int64_t tool_states_ns_ = 0;
  std::int64_t memory_checked_ns_ = 0;
  bool memory_lost_ = false;
};

}  // namespace palpate
