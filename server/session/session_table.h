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

/// Who drives what: admits stations, refuses them with a reason, ends their sessions.  A tool is
/// driven by one station at a time.  Knows no transport: requests come in, states go out.
///
/// A name is the run's that asked for it first, whether it is served, has sent no pose yet, or
/// waits for a teacher: another run gets it once that one has left with its key or has proved dead
/// by silence, and is refused where it lives.
///
/// What strangers ask costs no more than it must: a name is remembered only with a session, or by a
/// teacher's word about one, and refusals are so many a second.  Who is not answered asks again.
///
/// Thread contract: service thread.
class SessionTable {
 public:
  static constexpr std::size_t kMaxStations = 32;  ///< what the shared-memory pools are sized for
  /// How long a request under a name in use waits for the former run to prove dead (a station that
  /// was killed and started again) before it is refused; longer where that run has not had the time
  /// for its first pose.
  static constexpr std::int64_t kTakeOver_ns = 3 * Session::kSilence_ns;
  static constexpr double kRefusalsPerSecond = 20.0;
  static constexpr double kRefusalsAtOnce = 50.0;  ///< a class that starts at the same time
  /// A held station asks again every 2 s; one that does so no more has gone, and holds no place.
  static constexpr std::int64_t kHeld_ns = 10'000'000'000;
  /// The same for one under whose name another asks: two of its askings have not come.
  static constexpr std::int64_t kHeldAwaited_ns = 5'000'000'000;
  static constexpr std::size_t kMostNames = 1024;  ///< that teachers have spoken of

  /// @param admit_by_hand  stations wait until somebody admits them (Operate).
  SessionTable(std::vector<std::shared_ptr<const ServedTool>> tools, std::uint64_t server_run,
               bool admit_by_hand = false);

  void Request(const wire::SessionRequest& request, std::int64_t now_ns);
  /// What a teacher decides of a station.  It holds for the name until another word, whatever
  /// sessions come and go.  False: it is of another server, of a station that is not here, or has
  /// been heard before.
  bool Operate(const wire::OperateRequest& request, std::int64_t now_ns);
  /// Makes a scene whole again for all its tools, or as it was at its bookmark, and answers.  A
  /// request for a scene that is not
  /// served here gets no answer: it may be another server's.  Nor does one that has been heard.
  void Request(const wire::WholeRequest& request);
  /// Looks after all sessions; ended ones leave the table.
  void Update(std::int64_t now_ns);
  /// No more poses come to sessions that have ended: what their burs have cut is their scenes'.
  void RetireEnded(std::int64_t now_ns);
  /// After that, and before a session's first pose: what is left of its scene's solids is its own.
  void Begin(Session& session);
  /// Ends every session, to which no poses come any more: the server stops.
  void EndAll(const std::string& reason);

  /// Sessions that have not ended.
  const std::map<std::string, std::shared_ptr<Session>>& sessions() const { return sessions_; }
  /// States to publish since the last call, oldest first.
  std::vector<wire::SessionState> TakeChanges();
  /// What burs have left, block by block, as far as viewers are to be told of it now.
  std::vector<SolidBlockNews> TakeCuts(std::int64_t now_ns);
  /// One of these could not be published.
  void TellAgain(const wire::SolidBlock& block, std::int64_t now_ns);
  /// What sessions were given of each other's cuts, as recordings need it.
  std::vector<CutLogNews> TakeCutLogs(std::int64_t now_ns);
  /// When loops made their scenes whole, since the last call.
  std::vector<wire::LoopWhole> TakeLoopWholes();
  /// Scenes that were made whole since the last call, and refusals to do so.
  std::vector<wire::SceneWhole> TakeWholes();
  /// Refusals that were not told since the last call, there being so many.
  std::uint64_t TakeUntold() { return std::exchange(untold_, 0); }

 private:
  struct Waiting {
    wire::SessionRequest request;
    std::int64_t since_ns;  // of one that is held: when it asked last
  };
  /// Whose a name is that another run asks for.
  enum class Name { kUndecided, kFree, kTaken };
  /// By a teacher's word, of a name.
  struct Standing {
    bool admitted = false;
    std::string taken_back_by;  ///< empty: it is not
    bool muted = false;
  };

  /// The tool that the request means; null, with the reason, where it cannot be had.
  std::shared_ptr<const ServedTool> Find(const wire::SessionRequest& request,
                                         std::string& refusal) const;
  void Admit(const wire::SessionRequest& request, std::int64_t now_ns);
  /// Takes back what a run asked for, or ends its session, where the request has its key.
  void Leave(const wire::SessionRequest& request);
  /// False where the station has to wait for a teacher; then it does.
  bool MayBegin(const wire::SessionRequest& request, std::int64_t now_ns);
  void TellHeld(const wire::SessionRequest& request);
  void ForgetHeld(std::int64_t now_ns);
  Name StateOfName(const Waiting& successor, std::int64_t now_ns) const;
  void RefuseSuccessor(const wire::SessionRequest& request, std::int64_t now_ns);
  void Refuse(const wire::SessionRequest& request, const std::string& reason, std::int64_t now_ns);
  void Publish(const Session& session);
  /// What is the same in each answer to a request.
  wire::SessionState AnswerTo(const wire::SessionRequest& request, wire::SessionPhase phase,
                              const std::string& reason) const;
  void MakeWhole(SceneChanges& scene, wire::SceneWhole answer);
  void Bookmark(SceneChanges& scene, wire::SceneWhole answer);
  void Answer(SceneChanges& scene, wire::SceneWhole& answer);
  /// Those too to which poses may still come.
  std::vector<Session*> SessionsOf(const std::string& scene);
  /// Null where nothing is cut.
  CutExchange* CutsOf(const Session& session);
  static CutExchange::Changed TakerOf(SceneChanges& scene, std::int64_t now_ns);

  std::vector<std::shared_ptr<const ServedTool>> tools_;
  std::uint64_t server_run_;
  std::map<std::string, std::shared_ptr<Session>> sessions_;  // by station
  std::map<std::string, Waiting> waiting_;                    // by station: for who has the name
  std::map<std::string, Waiting> held_;                       // by station: for a teacher
  std::map<std::string, Standing> standings_;                 // by station
  bool admit_by_hand_;
  std::int64_t now_ns_ = 0;  // of the last Update
  RequestMemory requests_heard_;
  TokenBucket refusals_{kRefusalsPerSecond, kRefusalsAtOnce};
  std::uint64_t untold_ = 0;
  std::vector<wire::SessionState> changes_;
  std::map<std::string, std::string> cut_off_;  // by scene: whose session did not end by its wish
  std::map<std::string, SceneChanges> scenes_;  // by name; those that burs cut
  // Ended, and their poses may still be answered; of scenes with solids.
  std::vector<std::shared_ptr<Session>> ending_;
  std::vector<wire::LoopWhole> loop_wholes_;
  std::vector<wire::SceneWhole> wholes_;
};

}  // namespace palpate
