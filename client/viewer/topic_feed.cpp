#include "client/viewer/topic_feed.h"

#include <algorithm>
#include <optional>
#include <utility>

#include <spdlog/spdlog.h>

#include "client/viewer/page_messages.h"
#include "common/dds/random_run.h"
#include "common/dds/topics.h"
#include "common/error.h"
#include "common/files/bundle_hash.h"
#include "common/realtime/steady_clock.h"
#include "common/realtime/wall_clock.h"
#include "common/recording/recorded_type.h"

namespace palpate {
namespace {

constexpr const char* kMouseSchema =
    R"({"type":"object","properties":{"station":{"type":"string"},"scene":{"type":"string"},)"
    R"("tool":{"type":"string"},"phase":{"type":"string"},"reason":{"type":"string"}}})";

constexpr const char* kGoalSchema =
    R"({"type":"object","properties":{"scene":{"type":"string"},"text":{"type":"string"},)"
    R"("limit_N":{"type":"number"}}})";

constexpr const char* kAnswerSchema =
    R"({"type":"object","properties":{"tag":{"type":"integer"},"request":{"type":"string"},)"
    R"("refusal":{"type":"string"}}})";
constexpr const char* kReplaySchema =
    R"({"type":"object","properties":{"replay":{"type":"string"}}})";
constexpr const char* kObjectSchema = R"({"type":"object"})";
/// Replayers send their state five times a second.
constexpr std::int64_t kReplaySilent_ns = 5'000'000'000;
constexpr std::size_t kMostReplays = 16;  // at a time: anybody may claim to be one
constexpr std::int64_t kLook_ns = 100'000'000;
/// So many wishes to restore scenes are answered within a moment, at most.
constexpr std::size_t kOwnWishes = 256;

template <class T>
foxglove::Channel CdrChannel(TopicFeed::Channel id, const char* topic) {
  return {id,      std::string("/") + topic, "cdr", SchemaName(kTypeOf<T>), SchemaText(kTypeOf<T>),
          "omgidl"};
}

foxglove::Channel JsonChannel(TopicFeed::Channel id, const std::string& topic,
                              const std::string& type, const char* schema) {
  return {id, "/palpate/" + topic, "json", "palpate." + type, schema, "jsonschema"};
}

/// Returns the bundle's bytes within the CDR bytes: the type's last member, before the padding that
/// the encapsulation options count.
std::span<const std::uint8_t> BundleIn(const std::vector<std::uint8_t>& cdr,
                                       const wire::SceneBundle& sample) {
  const std::size_t length = sample.bundle._length;
  const std::size_t fill = cdr.size() >= 4 ? cdr[3] & 3u : 0;
  if (cdr.size() < 4 + length + fill) return {};
  return std::span(cdr).subspan(cdr.size() - fill - length, length);
}

}  // namespace

/// The readers of what servers, stations and replayers send.
struct TopicFeed::Readers {
  Readers(const dds::Participant& participant, std::shared_ptr<dds::Source> server)
      : on(participant), of(std::move(server)) {}

  const dds::Participant& on;
  const std::shared_ptr<dds::Source> of, anyone = std::make_shared<dds::Source>(dds::Source::kFew);
  dds::CdrReader<wire::ToolState> tool_states{on, dds::kToolStateTopic, dds::Qos::kStream, of};
  dds::CdrReader<wire::MovedState> moved{on, dds::kMovedStateTopic, dds::Qos::kStream, of};
  dds::CdrReader<wire::LoopStatistics> statistics{on, dds::kLoopStatisticsTopic, dds::Qos::kStream,
                                                  of};
  dds::CdrReader<wire::StationStatistics> stations{on, dds::kStationStatisticsTopic,
                                                   dds::Qos::kStream, anyone};
  dds::CdrReader<wire::SessionState> sessions{on, dds::kSessionStateTopic, dds::Qos::kSession, of};
  dds::CdrReader<wire::SceneWhole> wholes{on, dds::kSceneWholeTopic, dds::Qos::kSession, of};
  std::optional<dds::CdrReader<wire::SolidBlock>> blocks;  // none: this identity may not read them
  dds::CdrReader<wire::SceneBundle> bundles{on, dds::kSceneBundleTopic, dds::Qos::kSession, of};
  dds::CdrReader<wire::ReplayContents> replay_contents{on, dds::kReplayContentsTopic,
                                                       dds::Qos::kSession, anyone};
  dds::CdrReader<wire::ReplayState> replay_states{on, dds::kReplayStateTopic, dds::Qos::kSession,
                                                  anyone};
};

TopicFeed::TopicFeed(int domain, const dds::Network& network)
    : participant_(dds::Participant::Service(domain, network)),
      readers_(std::make_unique<Readers>(participant_, source_)) {
  try {
    wishes_ = {participant_, dds::kWholeRequestTopic, dds::Qos::kSession};
    replay_requests_ = {participant_, dds::kReplayRequestTopic, dds::Qos::kSession};
    operate_requests_ = {participant_, dds::kOperateRequestTopic, dds::Qos::kSession};
  } catch (const Error&) {
    if (!network.secured()) throw;
    spdlog::info("this gateway's --identity may watch, but send no requests");
  }
  try {
    readers_->blocks.emplace(participant_, dds::kSolidBlockTopic, dds::Qos::kSession, source_);
  } catch (const Error&) {
    if (!network.secured()) throw;
    spdlog::info(
        "this gateway's --identity has no right to receive cuts; make the identities of server and "
        "gateway again");
  }
  try {
    progress_ = {participant_, dds::kSceneProgressTopic, dds::Qos::kSession};
  } catch (const Error&) {
    if (!network.secured()) throw;
    spdlog::info("this gateway's --identity has no right to receive the progress of scenes");
  }
}

TopicFeed::~TopicFeed() = default;

bool TopicFeed::IsCurrent(std::uint64_t server_run, std::uint64_t origin) {
  if (origin == origin_) {
    // A participant may change its run number, as a replayer that seeks does.
    if (server_run == server_run_) return true;
    if (former_runs_.contains(server_run)) return false;
  } else if (lives_) {
    if (!others_heard_) {
      spdlog::warn(
          "another server ({:x}) in this domain is ignored, because the first one ({:x}) is still "
          "running; give one of them, its stations and its viewers another --domain",
          server_run, server_run_);
    }
    others_heard_ = true;
    return false;
  } else {
    origin_ = origin;
    lives_ = true;
    source_->Only(origin);
    others_heard_ = false;
    if (server_run == server_run_) return true;
    former_runs_.clear();
  }
  if (server_run_ != 0) former_runs_.insert(server_run_);
  server_run_ = server_run;
  kept_.clear();
  undone_.clear();
  scenes_.clear();
  sessions_.clear();
  return true;
}

bool TopicFeed::IsForeign(std::uint64_t origin) const {
  return lives_ && origin != origin_;
}

void TopicFeed::Succeed() {
  const std::int64_t now_ns = SteadyNanoseconds();
  if (now_ns - looked_ns_ < kLook_ns) return;
  looked_ns_ = now_ns;
  // Servers and replayers have writers of all topics.  Checked at intervals, not per message, since
  // a stranger may flood.
  lives_ = origin_ != 0 && readers_->sessions.Hears(origin_);
  source_->Only(lives_ ? origin_ : 0);
  others_heard_ |= source_->TakeRefused();
  if (lives_ || !others_heard_) return;
  others_heard_ = false;
  // The other server's ignored state has been taken from the readers; new ones receive it again.
  readers_ = std::make_unique<Readers>(participant_, source_);
}

void TopicFeed::Keep(const FramePtr& frame, const std::string& name, std::uint64_t number,
                     std::uint64_t change) {
  kept_[{frame->channel, name, number}] = {frame, change};
}

/// Takes all samples of a reader.
/// @param use   (frame, sample)   @param over  (origin, sample): its instance is disposed; the
/// sample has the key only.
template <class T, class Use, class Over>
void TopicFeed::Drain(dds::CdrReader<T>& reader, std::uint32_t channel, Use use, Over over) {
  dds::CdrSample raw;
  T sample{};
  while (reader.Take(raw, sample, true)) {
    if (raw.over) {
      over(raw.origin, sample);
      continue;
    }
    auto frame = std::make_shared<Frame>();
    frame->channel = channel;
    frame->instance = raw.instance;
    frame->origin = raw.origin;
    frame->time_ns = raw.source_time_ns;
    frame->payload = std::move(raw.cdr);
    frame->state = channel != kToolState && channel != kMovedState && channel != kLoopStatistics &&
                   channel != kStationStatistics;
    use(frame, sample);
  }
  dds::FreeContents(sample);
}

void TopicFeed::TakeSeat(const FramePtr& frame, const wire::SceneBundle& seat,
                         const std::function<void(const FramePtr&)>& on_frame) {
  const auto scene = std::ranges::find_if(
      scenes_, [&](const auto& entry) { return entry.second.hash == seat.hash; });
  if (scene == scenes_.end()) {
    return spdlog::warn("seat '{}' arrived before its scene, and is not shown", seat.scene);
  }
  Keep(frame, seat.scene, 0);
  const SceneBytes bytes = scene->second;  // shares the compressed bundle
  scenes_[seat.scene] = bytes;
  on_frame(frame);
}

void TopicFeed::Poll(const std::function<void(const FramePtr&)>& on_frame,
                     const std::function<void(const wire::SessionState&)>& on_session,
                     const std::function<void(const wire::SceneWhole&, bool is_own)>& on_whole) {
  Succeed();
  if (progress_) progress_.Take(compiling_);
  // Scenes first: a station's scene must be known before the station.
  Drain(readers_->bundles, kSceneBundle,
        [&](const FramePtr& frame, const wire::SceneBundle& sample) {
          if (!IsCurrent(sample.server_run, frame->origin)) return;
          if (sample.bundle._length == 0) return TakeSeat(frame, sample, on_frame);
          const std::span<const std::uint8_t> bundle = BundleIn(frame->payload, sample);
          if (BundleHash(bundle) != sample.hash) {
            return spdlog::warn("the bundle of a scene does not match its hash, and is not shown");
          }
          Keep(frame, sample.scene, 0);
          scenes_[sample.scene] = {frame, sample.hash, bundle};
          on_frame(frame);
        });
  const auto take_block = [&](const FramePtr& frame, const wire::SolidBlock& sample) {
    if (!IsCurrent(sample.server_run, frame->origin)) return;
    if (sample.change <= undone_[sample.scene]) return;
    const std::uint64_t object = sample.object_index;
    Keep(frame, sample.scene, object << 32 | sample.block, sample.change);
    on_frame(frame);
  };
  if (readers_->blocks) Drain(*readers_->blocks, kSolidBlock, take_block);
  // After the blocks: those that it undoes are forgotten.
  Drain(readers_->wholes, kSceneWhole, [&](const FramePtr& frame, const wire::SceneWhole& sample) {
    if (!IsCurrent(sample.server_run, frame->origin)) return;
    std::uint64_t& undone = undone_[sample.scene];
    if (sample.last_change < undone) return;  // an older message that was delayed
    undone = sample.last_change;
    std::erase_if(kept_, [&](const auto& entry) {
      const std::uint64_t change = entry.second.change;
      return change > 0 && change <= sample.last_change && std::get<1>(entry.first) == sample.scene;
    });
    Keep(frame, sample.scene, 0);
    on_frame(frame);
    on_whole(sample, std::ranges::find(own_wishes_, sample.request) != own_wishes_.end());
  });
  Drain(
      readers_->sessions, kSessionState,
      [&](const FramePtr& frame, const wire::SessionState& sample) {
        if (!IsCurrent(sample.server_run, frame->origin)) return;
        Keep(frame, sample.station, 0);
        sessions_[sample.station] = {sample.phase, sample.scene};
        on_frame(frame);
        on_session(sample);
      },
      [&](std::uint64_t origin, const wire::SessionState& sample) {
        // It was refused or ended some time ago; present viewers may keep showing it.
        if (origin != origin_) return;
        kept_.erase({kSessionState, sample.station, 0});
        sessions_.erase(sample.station);
      });
  // Before the data that it replays: a viewer must know first that it is a replay.
  PollReplays(on_frame);
  const auto of_server = [&](const FramePtr& frame, const auto&) {
    if (!IsForeign(frame->origin)) on_frame(frame);
  };
  Drain(readers_->moved, kMovedState, of_server);
  Drain(readers_->tool_states, kToolState, of_server);
  Drain(readers_->statistics, kLoopStatistics, of_server);
  Drain(readers_->stations, kStationStatistics,
        [&](const FramePtr& frame, const auto&) { on_frame(frame); });
}

void TopicFeed::PollReplays(const std::function<void(const FramePtr&)>& on_frame) {
  const auto tell = [&](const std::shared_ptr<Frame>& frame, const std::string& json) {
    frame->payload.assign(json.begin(), json.end());
    on_frame(frame);
  };
  Drain(readers_->replay_contents, kReplayContents,
        [&](const std::shared_ptr<Frame>& frame, const wire::ReplayContents& sample) {
          ReplayOf(sample.replay).contents = frame;
          tell(frame, ToJson(sample));
        });
  Drain(readers_->replay_states, kReplayState,
        [&](const std::shared_ptr<Frame>& frame, const wire::ReplayState& sample) {
          Replay& replay = ReplayOf(sample.replay);
          replay.state = frame;
          replay.heard_ns = SteadyNanoseconds();
          tell(frame, ToJson(sample));
        });
}

TopicFeed::Replay& TopicFeed::ReplayOf(std::uint64_t number) {
  if (!replays_.contains(number)) {
    const std::int64_t silent_ns = SteadyNanoseconds() - kReplaySilent_ns;
    std::erase_if(replays_, [&](const auto& entry) { return entry.second.heard_ns < silent_ns; });
    if (replays_.size() >= kMostReplays) replays_.erase(replays_.begin());
  }
  return replays_[number];
}

bool TopicFeed::AskForWhole(const std::string& scene, wire::WholeWish wish, const std::string& by) {
  if (!scenes_.contains(scene)) return false;
  wire::WholeRequest request{};
  wire::FromText(scene, request.scene);
  request.request = RandomRun();
  wire::FromText(by, request.by);
  request.wish = wish;
  own_wishes_.push_back(request.request);
  if (own_wishes_.size() > kOwnWishes) own_wishes_.pop_front();
  return wishes_ && wishes_.Write(request);
}

std::string TopicFeed::WhyAbsent(const std::string& scene) const {
  if (!lives_) {
    return server_run_ == 0 ? "there is no server yet"
                            : "there is no server: the last one has ended";
  }
  return scenes_.contains(scene) ? "" : "no server serves scene '" + scene + "'";
}

std::string TopicFeed::Ask(const wire::ReplayRequest& request) {
  if (!replays_.contains(request.replay)) return "that replay has ended";
  if (!replay_requests_) return "this gateway's identity may watch, but not steer a replay";
  return replay_requests_.Write(request) ? "" : "the network is busy; try again";
}

std::vector<FramePtr> TopicFeed::Kept(std::uint32_t channel) const {
  std::vector<FramePtr> frames;
  for (const auto& [number, replay] : replays_) {
    if (channel == kReplayContents && replay.contents) frames.push_back(replay.contents);
    // The state of a replayer that has died would look current.
    const bool speaks = SteadyNanoseconds() - replay.heard_ns < kReplaySilent_ns;
    if (channel == kReplayState && replay.state && speaks) frames.push_back(replay.state);
  }
  for (auto it = kept_.lower_bound({channel, "", 0});
       it != kept_.end() && std::get<0>(it->first) == channel; ++it) {
    frames.push_back(it->second.frame);
  }
  return frames;
}

const wire::SceneProgress* TopicFeed::compiling() const {
  // The writer exists only while its server compiles.
  const bool is_there = progress_ && progress_.matched_writers() > 0;
  return is_there && compiling_.scene[0] != '\0' ? &compiling_ : nullptr;
}

bool TopicFeed::HasStation(const std::string& name) const {
  const auto found = sessions_.find(name);
  return found != sessions_.end() && found->second.lives();
}

bool TopicFeed::HasStationIn(const std::string& scene) const {
  return std::ranges::any_of(sessions_, [&](const auto& entry) {
    return entry.second.lives() && entry.second.scene == scene;
  });
}

std::vector<std::string> TopicFeed::stations() const {
  std::vector<std::string> names;
  for (const auto& [station, session] : sessions_) {
    if (session.lives() && session.phase != palpate_SESSION_HELD) names.push_back(station);
  }
  return names;
}

std::vector<foxglove::Channel> ChannelsFor(bool mice, bool steers, bool of_course, bool teaches) {
  std::vector<foxglove::Channel> channels = {
      CdrChannel<wire::ToolState>(TopicFeed::kToolState, dds::kToolStateTopic),
      CdrChannel<wire::MovedState>(TopicFeed::kMovedState, dds::kMovedStateTopic),
      CdrChannel<wire::LoopStatistics>(TopicFeed::kLoopStatistics, dds::kLoopStatisticsTopic),
      CdrChannel<wire::StationStatistics>(TopicFeed::kStationStatistics,
                                          dds::kStationStatisticsTopic),
      CdrChannel<wire::SessionState>(TopicFeed::kSessionState, dds::kSessionStateTopic),
      CdrChannel<wire::SceneWhole>(TopicFeed::kSceneWhole, dds::kSceneWholeTopic),
      CdrChannel<wire::SceneBundle>(TopicFeed::kSceneBundle, dds::kSceneBundleTopic),
      CdrChannel<wire::SolidBlock>(TopicFeed::kSolidBlock, dds::kSolidBlockTopic),
      JsonChannel(TopicFeed::kReplayContents, "replay_contents", "ReplayContents", kReplaySchema),
      JsonChannel(TopicFeed::kReplayState, "replay_state", "ReplayState", kReplaySchema),
      JsonChannel(TopicFeed::kGoal, "goal", "SceneGoal", kGoalSchema)};
  if (mice) {
    channels.push_back(
        JsonChannel(TopicFeed::kMouseState, "mouse_state", "MouseState", kMouseSchema));
  }
  if (steers) {
    channels.push_back(
        JsonChannel(TopicFeed::kReplayAnswer, "replay_answer", "ReplayAnswer", kAnswerSchema));
  }
  if (of_course) channels.push_back(JsonChannel(TopicFeed::kMe, "me", "Me", kObjectSchema));
  if ((of_course && mice) || teaches) {
    channels.push_back(JsonChannel(TopicFeed::kExam, "exam_state", "ExamState", kObjectSchema));
  }
  if (of_course && mice) {
    channels.push_back(JsonChannel(TopicFeed::kExercises, "exercises", "Exercises", kObjectSchema));
    channels.push_back(JsonChannel(TopicFeed::kTrial, "trial_state", "TrialState", kObjectSchema));
  }
  if (teaches) {
    channels.push_back(JsonChannel(TopicFeed::kPeople, "people", "People", kObjectSchema));
    channels.push_back(
        JsonChannel(TopicFeed::kClassAnswer, "class_answer", "ClassAnswer", kObjectSchema));
    channels.push_back(
        JsonChannel(TopicFeed::kExamAnswer, "exam_answer", "ExamAnswer", kObjectSchema));
  }
  return channels;
}

FramePtr OwnFrame(TopicFeed::Channel channel, std::uint64_t instance, const std::string& json) {
  auto frame = std::make_shared<Frame>();
  frame->channel = channel;
  frame->instance = instance;
  frame->time_ns = WallClock_ns();
  frame->payload.assign(json.begin(), json.end());
  frame->state = true;
  return frame;
}

std::set<std::string> NamesOf(const std::map<std::string, SceneBytes>& scenes) {
  std::set<std::string> names;
  for (const auto& [name, scene] : scenes) names.insert(name);
  return names;
}

}  // namespace palpate
