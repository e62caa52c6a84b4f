#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "client/viewer/foxglove.h"
#include "client/viewer/frame_queue.h"
#include "common/dds/cdr_reader.h"

namespace palpate {

/// What ScenePacker knows of a scene: its bundle compressed, or who waits for that.
struct PackedScene {
  using Bytes = std::shared_ptr<const std::vector<std::uint8_t>>;
  Bytes bytes;
  std::vector<std::function<void(const Bytes&)>> waiting;
};

/// A scene as its server gave it.
struct SceneBytes {
  FramePtr frame;  ///< owns the bytes
  std::uint64_t hash = 0;
  std::span<const std::uint8_t> bundle;
  std::shared_ptr<PackedScene> packed = std::make_shared<PackedScene>();
};

/// The topics that viewers see, from the service domain, as frames: what has a state is kept for
/// those who come later.  One server is heard, the current one, for as long as it lives: what
/// others say meanwhile counts for nothing.  Once it has gone, the next takes its place; while
/// there is none, what is known stays. Thread contract: one thread.
class TopicFeed {
 public:
  enum Channel : std::uint32_t {
    kToolState = 1,
    kLoopStatistics,
    kSessionState,
    kSceneBundle,
    kMouseState,  ///< not of DDS: the gateway's own, to each viewer of the mouse that it has
    kStationStatistics,
    kSceneWhole,
    // As JSON, since pages are to read their numbers.
    kReplayContents,
    kReplayState,
    kReplayAnswer,  ///< not of DDS: the gateway's own, to each viewer of its own wishes
    kGoal,          ///< not of DDS: the gateway's own, what a teacher has set for a scene
    kSolidBlock,
    // Not of DDS: the gateway's own, of a --course.
    kMe,           ///< to each viewer, of itself
    kPeople,       ///< to those who may operate
    kClassAnswer,  ///< to each of those, of its own wishes
    kExercises,    ///< to each who may have a mouse there: what there is to do, and what was done
    kTrial,        ///< to each of those, of the own trial
    kExam,         ///< to each of a course: the open exam; to those who operate, all of it
    kExamAnswer,   ///< to each of those, of its own wishes
  };
  /// What viewers are offered.
  /// @param mice    who may have a mouse hears of it.
  /// @param steers  who may steer a replay is answered.
  /// @param of_course  who is one of a course hears of itself.
  /// @param teaches  and, who may operate there, of all.
  static std::vector<foxglove::Channel> Channels(bool mice, bool steers, bool of_course = false,
                                                 bool teaches = false);

  /// Throws Error where DDS refuses.
  explicit TopicFeed(int domain, const dds::Network& network = {});
  ~TopicFeed();

  /// Takes what has come.
  /// @param on_frame  each new frame.   @param on_session  each new state of a session, too.
  void Poll(const std::function<void(const FramePtr&)>& on_frame,
            const std::function<void(const wire::SessionState&)>& on_session);

  /// What who subscribes now must hear first, in the order in which it took place.
  std::vector<FramePtr> Kept(std::uint32_t channel) const;
  /// Passes a wish on to the server.  False where DDS refuses.
  bool Ask(const wire::WholeRequest& request) { return wishes_ && wishes_.Write(request); }
  bool Ask(const wire::OperateRequest& request) {
    return operate_requests_ && operate_requests_.Write(request);
  }
  /// Passes a wish on to its replay.  Returns why not; empty: it has.
  std::string Ask(const wire::ReplayRequest& request);
  const std::map<std::string, SceneBytes>& scenes() const { return scenes_; }
  /// Stations that have a session, as the server last said.
  std::vector<std::string> stations() const;
  /// A station of that name is there, be it that it waits to be admitted.
  bool HasStation(const std::string& name) const;
  /// False where there is no server, or the one that was heard last has gone.
  bool server_lives() const { return lives_; }
  /// What a server compiles that serves nothing yet; null: none does so.
  const wire::SceneProgress* compiling() const;
  /// The server's that was heard last; 0: none has been.
  std::uint64_t server_run() const { return server_run_; }

 private:
  /// What a replayer says of itself.
  struct Replay {
    FramePtr contents;
    FramePtr state;
    std::int64_t heard_ns = 0;  // its state, by the steady clock
  };
  struct Nothing {
    void operator()(const auto&...) const {}
  };
  using KeptKey = std::tuple<std::uint32_t, std::string, std::uint64_t>;  // channel, name, number
  struct KeptFrame {
    FramePtr frame;
    std::uint64_t change = 0;  // of its scene: void where that is undone; 0: none
  };

  template <class T, class Use, class Over = Nothing>
  void Drain(dds::CdrReader<T>& reader, std::uint32_t channel, Use use, Over over = {});
  struct Readers;
  /// False for a word that is not the current server's.  A new one's first word clears the
  /// former's.
  bool IsCurrent(std::uint64_t server_run, std::uint64_t origin);
  /// True for what is not the current server's, while that lives.
  bool IsForeign(std::uint64_t origin) const;
  /// Looks whether the current server lives.  Once it has gone, what another has said meanwhile is
  /// heard anew.
  void Succeed();
  void Keep(const FramePtr& frame, const std::string& name, std::uint64_t number,
            std::uint64_t change = 0);
  /// A scene's other name: it comes after the scene.
  void TakeSeat(const FramePtr& frame, const wire::SceneBundle& seat,
                const std::function<void(const FramePtr&)>& on_frame);
  void PollReplays(const std::function<void(const FramePtr&)>& on_frame);
  /// Of this number, new or known.  A new one takes the place of those that are silent.
  Replay& ReplayOf(std::uint64_t number);

  dds::Participant participant_;
  dds::Reader<wire::SceneProgress> progress_;
  std::unique_ptr<Readers> readers_;
  dds::Writer<wire::WholeRequest> wishes_;
  dds::Writer<wire::ReplayRequest> replay_requests_;
  dds::Writer<wire::OperateRequest> operate_requests_;

  std::uint64_t server_run_ = 0;
  std::uint64_t origin_ = 0;             // of the server: its participant
  std::set<std::uint64_t> former_runs_;  // of that participant
  bool others_heard_ = false;            // while it lives
  bool lives_ = false;                   // when it was last looked at
  std::int64_t looked_ns_ = 0;
  std::map<KeptKey, KeptFrame> kept_;
  std::map<std::string, std::uint64_t> undone_;  // by scene: the last change that is void
  std::map<std::string, SceneBytes> scenes_;
  std::map<std::string, wire::SessionPhase> phases_;  // by station
  wire::SceneProgress compiling_{};
  // By number.  Apart from what is kept: where a replay goes elsewhere, it speaks as another
  // server.
  std::map<std::uint64_t, Replay> replays_;
};

}  // namespace palpate
