#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/dds/request_memory.h"
#include "common/dds/wire.h"
#include "common/realtime/token_bucket.h"
#include "server/session/scene_changes.h"
#include "server/session/session.h"

namespace palpate {

/// All sessions: admits stations, refuses them with a reason, ends their sessions.  One station at
/// a time drives a tool.  Knows no transport: requests come in, states go out.
///
/// A station's name belongs to the run that asked for it first, whether that run is served, has
/// sent no pose yet, or waits for a teacher.  Another run gets the name once the first has left
/// with its key or has been silent long enough to count as dead; until then it is refused.
///
/// Requests from strangers cost a bounded amount: a name is stored only with a session or after a
/// teacher's decision about it, and refusals are limited per second.  A client that gets no answer
/// asks again.
///
/// Thread contract: service thread.
class SessionTable {
 public:
  static constexpr std::size_t kMaxStations = 32;  ///< as the shared-memory pools are sized
  /// How long a request under a name in use waits for the former run to count as dead (a
  /// station that was killed and restarted) before it is refused, in pauses of its poses; longer if
  /// that run still has time for its first pose.
  static constexpr std::int64_t kTakeOverPauses = 3;
  static constexpr double kRefusalsPerSecond = 20.0;
  static constexpr double kRefusalsAtOnce = 50.0;  ///< for a class that starts all at once
  /// A held station asks again every 2 s.  After this time without a request it loses its place.
  static constexpr std::int64_t kHeld_ns = 10'000'000'000;
  /// The same if another run asks under its name: two of its requests are missing.
  static constexpr std::int64_t kHeldAwaited_ns = 5'000'000'000;
  static constexpr std::size_t kMostNames = 1024;  ///< about which teachers have decided

  /// Throws Error if hands shall meet that cannot.
  /// @param admit_by_hand  stations wait until somebody admits them (Operate)
  SessionTable(std::vector<std::shared_ptr<const ServedTool>> tools, std::uint64_t server_run,
               bool admit_by_hand = false);

  void Request(const wire::SessionRequest& request, std::int64_t now_ns);
  /// Applies a teacher's decision about a station.  It holds for the name until the next decision,
  /// whatever sessions come and go.  Returns false if the request is for another server, names a
  /// station that is not here, or was handled before.
  bool Operate(const wire::OperateRequest& request, std::int64_t now_ns);
  /// Makes a scene whole for all its tools, or restores its bookmark, and answers; refuses it while
  /// a station keeps the scene as it is (SessionRequest.keeps_scene).  A request for a scene that
  /// is not served here gets no answer, because it may be meant for another server; nor does one
  /// that was handled before.
  void Request(const wire::WholeRequest& request);
  /// Updates all sessions; removes ended ones from the table.
  void Update(std::int64_t now_ns);
  /// Call when no more poses come to ended sessions: the cuts of their burs become their scenes',
  /// and their hands leave the others'.
  void RetireEnded(std::int64_t now_ns);
  /// Call after RetireEnded and before a session's first pose: gives it the current state
  /// of its scene's solids.
  void Begin(Session& session);
  /// Ends every session when the server stops; no poses may come to them any more.
  void EndAll(const std::string& reason);

  /// The sessions that have not ended, by station.
  const std::map<std::string, std::shared_ptr<Session>>& sessions() const { return sessions_; }
  /// Returns the states to publish since the last call, oldest first.
  std::vector<wire::SessionState> TakeChanges();
  /// Returns the changed blocks of solids that are to be published to viewers now.
  std::vector<SolidBlockNews> TakeCuts(std::int64_t now_ns);
  /// Notes that one of these could not be published.
  void TellAgain(const wire::SolidBlock& block, std::int64_t now_ns);
  /// Returns the logs of the cuts that sessions were given of each other, for recordings.
  std::vector<CutLogNews> TakeCutLogs(std::int64_t now_ns);
  /// Returns when loops made their scenes whole, since the last call.
  std::vector<wire::LoopWhole> TakeLoopWholes();
  /// Returns the scenes that were made whole since the last call, and refusals to do so.
  std::vector<wire::SceneWhole> TakeWholes();
  /// Returns the number of refusals since the last call that were too many to be published.
  std::uint64_t TakeUntold() { return std::exchange(untold_, 0); }

 private:
  struct Waiting {
    wire::SessionRequest request;
    std::int64_t since_ns;  // for a held station: time of its latest request
  };
  /// State of a name that another run asks for.
  enum class Name { kUndecided, kFree, kTaken };
  /// A teacher's decision about a name.
  struct Standing {
    bool admitted = false;
    std::string taken_back_by;  ///< empty if it was not taken back
    bool muted = false;
  };

  /// Returns the tool that a request means; null, with the reason in `refusal`, if
  /// it is not available.
  std::shared_ptr<const ServedTool> Find(const wire::SessionRequest& request,
                                         std::string& refusal) const;
  void Admit(const wire::SessionRequest& request, std::int64_t now_ns);
  /// Withdraws a run's request, or ends its session, if the message has the run's key.
  void Leave(const wire::SessionRequest& request);
  /// Returns false if the station must wait for a teacher, and then puts it on hold.
  bool MayBegin(const wire::SessionRequest& request, std::int64_t now_ns);
  void TellHeld(const wire::SessionRequest& request);
  void ForgetHeld(std::int64_t now_ns);
  Name StateOfName(const Waiting& successor, std::int64_t now_ns) const;
  void RefuseSuccessor(const wire::SessionRequest& request, std::int64_t now_ns);
  void Refuse(const wire::SessionRequest& request, const std::string& reason, std::int64_t now_ns);
  void Publish(const Session& session);
  /// Fills what all answers to a request have in common.
  wire::SessionState AnswerTo(const wire::SessionRequest& request, wire::SessionPhase phase,
                              const std::string& reason) const;
  void MakeWhole(SceneChanges& scene, wire::SceneWhole answer);
  void Bookmark(SceneChanges& scene, wire::SceneWhole answer);
  void Answer(SceneChanges& scene, wire::SceneWhole& answer);
  /// Returns the station that lets nobody restore the scene; empty: anybody may.
  std::string KeeperOf(const std::string& scene) const;
  /// Returns the sessions of a scene, including those to which poses may still come.
  std::vector<Session*> SessionsOf(const std::string& scene);
  /// Null if nothing can be cut.
  CutExchange* CutsOf(const Session& session);
  /// Returns the loop of a tool whose hand meets others; null for any other tool.
  std::unique_ptr<ServoLoop> LoopOf(const ServedTool& tool) const;
  static CutExchange::Changed TakerOf(SceneChanges& scene, std::int64_t now_ns);

  std::vector<std::shared_ptr<const ServedTool>> tools_;
  std::uint64_t server_run_;
  std::map<std::string, std::shared_ptr<Session>> sessions_;  // by station
  std::map<std::string, Waiting> waiting_;                    // by station: waiting for the name
  std::map<std::string, Waiting> held_;                       // by station: waiting for a teacher
  std::map<std::string, Standing> standings_;                 // by station
  bool admit_by_hand_;
  std::int64_t now_ns_ = 0;  // of the last Update
  RequestMemory requests_heard_;
  TokenBucket refusals_{kRefusalsPerSecond, kRefusalsAtOnce};
  std::uint64_t untold_ = 0;
  std::vector<wire::SessionState> changes_;
  std::map<std::string, std::string> cut_off_;            // by scene: whose session was cut off
  std::map<std::string, SceneChanges> scenes_;            // by name; those that burs can cut
  std::map<std::string, std::shared_ptr<World>> worlds_;  // by scene, in which hands meet
  // Sessions that have ended but may still answer poses.
  std::vector<std::shared_ptr<Session>> ending_;
  std::vector<wire::LoopWhole> loop_wholes_;
  std::vector<wire::SceneWhole> wholes_;
};

}  // namespace palpate
