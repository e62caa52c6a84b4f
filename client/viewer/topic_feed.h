#pragma once

#include <cstdint>
#include <deque>
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

/// ScenePacker's state of a scene: the compressed bundle, or who waits for it.
struct PackedScene {
  using Bytes = std::shared_ptr<const std::vector<std::uint8_t>>;
  Bytes bytes;
  std::vector<std::function<void(const Bytes&)>> waiting;
};

/// A scene as the server published it.
struct SceneBytes {
  FramePtr frame;  ///< owns the bytes
  std::uint64_t hash = 0;
  std::span<const std::uint8_t> bundle;
  std::shared_ptr<PackedScene> packed = std::make_shared<PackedScene>();
};

/// Turns the topics of the service domain into frames for viewers, and keeps those with state for
/// viewers that connect later.  Only one server is heard, the current one, as long as it lives;
/// messages of others are dropped as they arrive.  When it has gone, another may take its place;
/// until then its last state is kept. Thread contract: one thread.
class TopicFeed {
 public:
  enum Channel : std::uint32_t {
    kToolState = 1,
    kLoopStatistics,
    kSessionState,
    kSceneBundle,
    kMouseState,  ///< the gateway's own, not DDS: to each viewer, about its mouse
    kStationStatistics,
    kSceneWhole,
    // As JSON, with 64-bit identifiers as text.
    kReplayContents,
    kReplayState,
    kReplayAnswer,  ///< the gateway's own, not DDS: to each viewer, about its wishes
    kGoal,          ///< the gateway's own, not DDS: what a teacher has set for a scene
    kSolidBlock,
    // The gateway's own, not DDS, with --course.
    kMe,           ///< to each viewer, about itself
    kPeople,       ///< to operators
    kClassAnswer,  ///< to each operator, about its commands
    kExercises,    ///< to each person who may have a mouse: the exercises and trials so far
    kTrial,        ///< to each of those people, about their own trial
    kExam,         ///< to each of those people: the open exam; to operators: all of it
    kExamAnswer,   ///< to each operator, about its commands
    kMovedState,
  };
  /// Throws Error if DDS fails.
  explicit TopicFeed(int domain, const dds::Network& network = {});
  ~TopicFeed();

  struct Nothing {
    void operator()(const auto&...) const {}
  };

  /// Takes all new messages.
  /// @param on_frame  called for each frame.   @param on_session  also for each session state.
  /// @param on_whole  also for each answer to a wish to restore a scene; `is_own`: to AskForWhole.
  void Poll(const std::function<void(const FramePtr&)>& on_frame,
            const std::function<void(const wire::SessionState&)>& on_session,
            const std::function<void(const wire::SceneWhole&, bool is_own)>& on_whole = Nothing{});

  /// Returns the frames that a new subscriber must get first.
  std::vector<FramePtr> Kept(std::uint32_t channel) const;
  /// Asks the server to restore a scene, or for another WholeWish.  Returns false if there is
  /// no such scene, or DDS fails.
  bool AskForWhole(const std::string& scene, wire::WholeWish wish, const std::string& by);
  /// Forwards a request to the server.  Returns false if DDS fails.
  bool Ask(const wire::OperateRequest& request) {
    return operate_requests_ && operate_requests_.Write(request);
  }
  /// Forwards a request to its replay.  Returns why it failed; empty: it is sent.
  std::string Ask(const wire::ReplayRequest& request);
  const std::map<std::string, SceneBytes>& scenes() const { return scenes_; }
  /// Stations that have a session, as last reported by the server.
  std::vector<std::string> stations() const;
  /// Returns whether there is a station of that name, even if it still waits to be admitted.
  bool HasStation(const std::string& name) const;
  /// Returns whether a station has, or waits for, a tool of that scene.
  bool HasStationIn(const std::string& scene) const;
  /// Returns the progress of a server that still compiles its scenes; null: none does.
  const wire::SceneProgress* compiling() const;
  struct Server {
    std::uint64_t run = 0;  ///< number of the one that was heard last; 0: none
    bool lives = false;     ///< false if there is none, or the last one has gone
  };
  Server server() const { return {server_run_, lives_}; }
  /// Returns why a scene's tools are not available now; empty: they are.
  std::string WhyAbsent(const std::string& scene) const;

 private:
  /// The last messages of a replayer.
  struct Replay {
    FramePtr contents;
    FramePtr state;
    std::int64_t heard_ns = 0;  // when its state was heard, steady clock
  };
  using KeptKey = std::tuple<std::uint32_t, std::string, std::uint64_t>;  // channel, name, number
  struct KeptFrame {
    FramePtr frame;
    std::uint64_t change = 0;  // to its scene, by number: void once that is undone; 0: none
  };

  template <class T, class Use, class Over = Nothing>
  void Drain(dds::CdrReader<T>& reader, std::uint32_t channel, Use use, Over over = {});
  struct Readers;
  /// Returns false for a message that is not the current server's.  The first message of a new
  /// server clears the state of the former.
  bool IsCurrent(std::uint64_t server_run, std::uint64_t origin);
  /// Returns whether a message is not the current server's while that lives.
  bool IsForeign(std::uint64_t origin) const;
  /// Checks whether the current server lives.  Once it has gone, the ignored state of another
  /// is read again.
  void Succeed();
  void Keep(const FramePtr& frame, const std::string& name, std::uint64_t number,
            std::uint64_t change = 0);
  /// Takes another name of a scene, which must have arrived before.
  void TakeSeat(const FramePtr& frame, const wire::SceneBundle& seat,
                const std::function<void(const FramePtr&)>& on_frame);
  void PollReplays(const std::function<void(const FramePtr&)>& on_frame);
  /// Finds or adds a replay.  A new one replaces those that are silent.
  Replay& ReplayOf(std::uint64_t number);

  dds::Participant participant_;
  const std::shared_ptr<dds::Source> source_ = std::make_shared<dds::Source>();  // the server
  dds::Reader<wire::SceneProgress> progress_;
  std::unique_ptr<Readers> readers_;
  dds::Writer<wire::WholeRequest> wishes_;
  std::deque<std::uint64_t> own_wishes_;  // the last of them, by number
  dds::Writer<wire::ReplayRequest> replay_requests_;
  dds::Writer<wire::OperateRequest> operate_requests_;

  std::uint64_t server_run_ = 0;
  std::uint64_t origin_ = 0;             // the server's participant
  std::set<std::uint64_t> former_runs_;  // of that participant
  bool others_heard_ = false;            // while the current server lives
  bool lives_ = false;                   // when that was last checked
  std::int64_t looked_ns_ = 0;
  std::map<KeptKey, KeptFrame> kept_;
  std::map<std::string, std::uint64_t> undone_;  // by scene: the last change that was undone
  std::map<std::string, SceneBytes> scenes_;
  struct Session {
    wire::SessionPhase phase = palpate_SESSION_ENDED;
    std::string scene;
    bool lives() const {
      return phase != palpate_SESSION_ENDED && phase != palpate_SESSION_REFUSED;
    }
  };
  std::map<std::string, Session> sessions_;  // by station
  wire::SceneProgress compiling_{};
  // By number.  Not in kept_: a replay that seeks speaks as a new server.
  std::map<std::uint64_t, Replay> replays_;
};

/// Returns the channels that a viewer is offered.
/// @param mice       it may have a mouse.
/// @param steers     it may steer a replay.
/// @param of_course  its token is a person's of the course.
/// @param teaches    it may operate in the course.
std::vector<foxglove::Channel> ChannelsFor(bool mice, bool steers, bool of_course = false,
                                           bool teaches = false);

/// Makes a frame of the gateway's own.
FramePtr OwnFrame(TopicFeed::Channel channel, std::uint64_t instance, const std::string& json);

/// Returns the names of scenes, of TopicFeed::scenes.
std::set<std::string> NamesOf(const std::map<std::string, SceneBytes>& scenes);

}  // namespace palpate
