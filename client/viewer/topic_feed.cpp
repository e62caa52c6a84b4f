#include "client/viewer/topic_feed.h"

#include <algorithm>
#include <utility>

#include "client/viewer/replay_messages.h"
#include "common/dds/topics.h"
#include "common/random_run.h"
#include "common/recording/recorded_type.h"
#include "common/time/steady_clock.h"

namespace palpate {
namespace {

constexpr const char* kMouseSchema =
    R"({"type":"object","properties":{"station":{"type":"string"},"scene":{"type":"string"},)"
    R"("tool":{"type":"string"},"phase":{"type":"string"},"reason":{"type":"string"}}})";

constexpr const char* kAnswerSchema =
    R"({"type":"object","properties":{"tag":{"type":"integer"},"request":{"type":"string"},)"
    R"("refusal":{"type":"string"}}})";
constexpr const char* kReplaySchema =
    R"({"type":"object","properties":{"replay":{"type":"string"}}})";
/// Replayers speak five times a second.
constexpr std::int64_t kReplaySilent_ns = 5'000'000'000;

template <class T>
foxglove::Channel CdrChannel(TopicFeed::Channel id, const char* topic) {
  return {id,      std::string("/") + topic, "cdr", SchemaName(kTypeOf<T>), SchemaText(kTypeOf<T>),
          "omgidl"};
}

foxglove::Channel JsonChannel(TopicFeed::Channel id, const std::string& topic,
                              const std::string& type, const char* schema) {
  return {id, "/palpate/" + topic, "json", "palpate." + type, schema, "jsonschema"};
}

/// The bundle's bytes within those that travelled: the type's last member, before the filling up to
/// a word that the encapsulation's options count.
std::span<const std::uint8_t> BundleIn(const std::vector<std::uint8_t>& cdr,
                                       const wire::SceneBundle& sample) {
  const std::size_t length = sample.bundle._length;
  const std::size_t fill = cdr.size() >= 4 ? cdr[3] & 3u : 0;
  if (cdr.size() < 4 + length + fill) return {};
  return std::span(cdr).subspan(cdr.size() - fill - length, length);
}

}  // namespace

std::vector<foxglove::Channel> TopicFeed::Channels(bool mice, bool steers) {
  std::vector<foxglove::Channel> channels = {
      CdrChannel<wire::ToolState>(kToolState, dds::kToolStateTopic),
      CdrChannel<wire::LoopStatistics>(kLoopStatistics, dds::kLoopStatisticsTopic),
      CdrChannel<wire::StationStatistics>(kStationStatistics, dds::kStationStatisticsTopic),
      CdrChannel<wire::SessionState>(kSessionState, dds::kSessionStateTopic),
      CdrChannel<wire::SceneChange>(kSceneChange, dds::kSceneChangeTopic),
      CdrChannel<wire::SceneWhole>(kSceneWhole, dds::kSceneWholeTopic),
      CdrChannel<wire::SceneBundle>(kSceneBundle, dds::kSceneBundleTopic),
      JsonChannel(kReplayContents, "replay_contents", "ReplayContents", kReplaySchema),
      JsonChannel(kReplayState, "replay_state", "ReplayState", kReplaySchema)};
  if (mice) {
    channels.push_back(JsonChannel(kMouseState, "mouse_state", "MouseState", kMouseSchema));
  }
  if (steers) {
    channels.push_back(JsonChannel(kReplayAnswer, "replay_answer", "ReplayAnswer", kAnswerSchema));
  }
  return channels;
}

TopicFeed::TopicFeed(int domain, const dds::Network& network)
    : participant_(dds::Participant::Service(domain, network)),
      tool_states_(participant_, dds::kToolStateTopic, dds::Qos::kStream),
      statistics_(participant_, dds::kLoopStatisticsTopic, dds::Qos::kStream),
      stations_(participant_, dds::kStationStatisticsTopic, dds::Qos::kStream),
      sessions_(participant_, dds::kSessionStateTopic, dds::Qos::kSession),
      changes_(participant_, dds::kSceneChangeTopic, dds::Qos::kSession),
      wholes_(participant_, dds::kSceneWholeTopic, dds::Qos::kSession),
      bundles_(participant_, dds::kSceneBundleTopic, dds::Qos::kSession),
      wishes_(participant_, dds::kWholeRequestTopic, dds::Qos::kSession),
      replay_contents_(participant_, dds::kReplayContentsTopic, dds::Qos::kSession),
      replay_states_(participant_, dds::kReplayStateTopic, dds::Qos::kSession),
      replay_requests_(participant_, dds::kReplayRequestTopic, dds::Qos::kSession),
      operate_requests_(participant_, dds::kOperateRequestTopic, dds::Qos::kSession) {}

TopicFeed::~TopicFeed() = default;

bool TopicFeed::IsCurrent(std::uint64_t server_run) {
  if (server_run == server_run_) return true;
  if (former_runs_.contains(server_run)) return false;
  if (server_run_ != 0) former_runs_.insert(server_run_);
  server_run_ = server_run;
  kept_.clear();
  undone_.clear();
  scenes_.clear();
  phases_.clear();
  return true;
}

void TopicFeed::Keep(const FramePtr& frame, const std::string& name, std::uint64_t number) {
  kept_[{frame->channel, name, number}] = frame;
}

/// @param use  (frame, sample): false where the sample is of no interest any more.
template <class T, class Use>
void TopicFeed::Drain(dds::CdrReader<T>& reader, std::uint32_t channel, Use use) {
  dds::CdrSample raw;
  T sample{};
  while (reader.Take(raw, sample)) {
    auto frame = std::make_shared<Frame>();
    frame->channel = channel;
    frame->instance = raw.instance;
    frame->time_ns = raw.source_time_ns;
    frame->payload = std::move(raw.cdr);
    frame->state =
        channel != kToolState && channel != kLoopStatistics && channel != kStationStatistics;
    use(frame, sample);
  }
  dds::FreeContents(sample);
}

void TopicFeed::Poll(const std::function<void(const FramePtr&)>& on_frame,
                     const std::function<void(const wire::SessionState&)>& on_session) {
  // Scenes first: who hears of a station should know where it is.
  Drain(bundles_, kSceneBundle, [&](const FramePtr& frame, const wire::SceneBundle& sample) {
    if (!IsCurrent(sample.server_run)) return;
    Keep(frame, sample.scene, 0);
    scenes_[sample.scene] = {frame, sample.hash, BundleIn(frame->payload, sample)};
    on_frame(frame);
  });
  Drain(changes_, kSceneChange, [&](const FramePtr& frame, const wire::SceneChange& sample) {
    if (!IsCurrent(sample.server_run) || sample.change <= undone_[sample.scene]) return;
    Keep(frame, sample.scene, sample.change);
    on_frame(frame);
  });
  // After the changes: those that it undoes are forgotten.
  Drain(wholes_, kSceneWhole, [&](const FramePtr& frame, const wire::SceneWhole& sample) {
    if (!IsCurrent(sample.server_run)) return;
    std::uint64_t& undone = undone_[sample.scene];
    if (sample.last_change < undone) return;  // an older word, on a slower way
    undone = sample.last_change;
    std::erase_if(kept_, [&](const auto& entry) {
      const auto& [channel, scene, number] = entry.first;
      return channel == kSceneChange && scene == sample.scene && number <= sample.last_change;
    });
    Keep(frame, sample.scene, 0);
    on_frame(frame);
  });
  Drain(sessions_, kSessionState, [&](const FramePtr& frame, const wire::SessionState& sample) {
    if (!IsCurrent(sample.server_run)) return;
    Keep(frame, sample.station, 0);
    phases_[sample.station] = sample.phase;
    on_frame(frame);
    on_session(sample);
  });
  // Before what it replays: who sees that should know what it is.
  PollReplays(on_frame);
  const auto pass_on = [&](const FramePtr& frame, const auto&) { on_frame(frame); };
  Drain(tool_states_, kToolState, pass_on);
  Drain(statistics_, kLoopStatistics, pass_on);
  Drain(stations_, kStationStatistics, pass_on);
}

void TopicFeed::PollReplays(const std::function<void(const FramePtr&)>& on_frame) {
  const auto tell = [&](const std::shared_ptr<Frame>& frame, const std::string& json) {
    frame->payload.assign(json.begin(), json.end());
    on_frame(frame);
  };
  Drain(replay_contents_, kReplayContents,
        [&](const std::shared_ptr<Frame>& frame, const wire::ReplayContents& sample) {
          ReplayOf(sample.replay).contents = frame;
          tell(frame, ToJson(sample));
        });
  Drain(replay_states_, kReplayState,
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
  }
  return replays_[number];
}

std::string TopicFeed::AskReplay(const wire::ReplayRequest& request) {
  if (!replays_.contains(request.replay)) return "that replay is not there any more";
  return replay_requests_.Write(request) ? "" : "the network does not take it now; try again";
}

bool TopicFeed::AskForWhole(const std::string& scene, const std::string& by) {
  wire::WholeRequest request{};
  wire::FromText(scene, request.scene);
  request.request = RandomRun();
  wire::FromText(by, request.by);
  return wishes_.Write(request);
}

bool TopicFeed::AskOperate(const wire::OperateRequest& request) {
  return operate_requests_.Write(request);
}

std::vector<FramePtr> TopicFeed::Kept(std::uint32_t channel) const {
  std::vector<FramePtr> frames;
  for (const auto& [number, replay] : replays_) {
    if (channel == kReplayContents && replay.contents) frames.push_back(replay.contents);
    // What a replayer said that has died since would pass for news.
    const bool speaks = SteadyNanoseconds() - replay.heard_ns < kReplaySilent_ns;
    if (channel == kReplayState && replay.state && speaks) frames.push_back(replay.state);
  }
  for (auto it = kept_.lower_bound({channel, "", 0});
       it != kept_.end() && std::get<0>(it->first) == channel; ++it) {
    frames.push_back(it->second);
  }
  return frames;
}

std::vector<std::string> TopicFeed::stations() const {
  std::vector<std::string> names;
  for (const auto& [station, phase] : phases_) {
    if (phase != palpate_SESSION_ENDED && phase != palpate_SESSION_REFUSED)
      names.push_back(station);
  }
  return names;
}

}  // namespace palpate
