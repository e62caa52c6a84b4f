#include "client/recorder/taps.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

#include "common/dds/topics.h"
#include "common/realtime/steady_clock.h"

namespace palpate {
namespace {

/// Loop topics stay open this long after a session ends, for samples still in flight.
constexpr std::int64_t kLinger_ns = 500'000'000;
/// A server with a session says something 60 times a second.  One that was killed is silent at
/// once, but DDS misses it only after its lease of 3 s, and its successor may have begun within
/// half a second: so after the first time anybody is heard as well, after the second in its place.
constexpr std::int64_t kSilent_ns = 100'000'000, kGone_ns = 1'500'000'000;
constexpr std::int64_t kLook_ns = 50'000'000;
template <class T>
constexpr bool kFromServer =
    !std::is_same_v<T, wire::SessionRequest> && !std::is_same_v<T, wire::WholeRequest> &&
    !std::is_same_v<T, wire::GuideTarget> && !std::is_same_v<T, wire::StationStatistics>;
constexpr std::array<std::uint8_t, 4> kCdrHead = {0, 1, 0, 0};
/// A pose that finds no room is lost, and a trial cannot be verified from there on.  The kernel
/// doubles this, and a sample takes up to 1.3 kB: half a second of twenty stations, ten of one.
constexpr std::uint32_t kReceiveBuffer = std::uint32_t{16} << 20;

dds::Network Roomy(dds::Network network) {
  network.receive_buffer = kReceiveBuffer;
  return network;
}

}  // namespace

std::int64_t RecordingTime_ns() {
  static const std::int64_t offset_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(
                                            std::chrono::system_clock::now().time_since_epoch())
                                            .count() -
                                        SteadyNanoseconds();
  return offset_ns + SteadyNanoseconds();
}

Taps::Taps(int domain, const dds::Network& network, const dds::TransportChoice& transport,
           bool loop, std::vector<std::string> stations, SampleQueue& queue, TappedTopics& topics)
    : wanted_(std::move(stations)),
      queue_(queue),
      topics_(topics),
      service_(dds::Participant::Service(domain, Roomy(network))),
      loop_(loop ? std::make_unique<dds::Participant>(
                       dds::Participant::Loop(domain, transport, Roomy(network)))
                 : nullptr) {
  RecordingTime_ns();
  TapServer();
  TapOthers();
}

void Taps::TapServer() {
  drains_.clear();
  TapService<wire::SceneBundle>(dds::kSceneBundleTopic, dds::Qos::kRecordSession);
  TapService<wire::SceneOffer>(dds::kSceneOfferTopic, dds::Qos::kRecordSession);
  states_ = TapService<wire::SessionState>(dds::kSessionStateTopic, dds::Qos::kRecordSession);
  TapService<wire::SolidBlock>(dds::kSolidBlockTopic, dds::Qos::kRecordSession);
  TapService<wire::CutLog>(dds::kCutLogTopic, dds::Qos::kRecordSession);
  TapService<wire::LoopWhole>(dds::kLoopWholeTopic, dds::Qos::kRecordSession);
  TapService<wire::SceneWhole>(dds::kSceneWholeTopic, dds::Qos::kRecordSession);
  TapService<wire::ToolState>(dds::kToolStateTopic, dds::Qos::kRecord);
  TapService<wire::MovedState>(dds::kMovedStateTopic, dds::Qos::kRecord);
  TapService<wire::LoopStatistics>(dds::kLoopStatisticsTopic, dds::Qos::kRecord);
}

void Taps::TapOthers() {
  TapService<wire::SessionRequest>(dds::kSessionRequestTopic, dds::Qos::kRecordSession);
  TapService<wire::WholeRequest>(dds::kWholeRequestTopic, dds::Qos::kRecordSession);
  TapService<wire::GuideTarget>(dds::kGuideTopic, dds::Qos::kRecord);
  TapService<wire::StationStatistics>(dds::kStationStatisticsTopic, dds::Qos::kRecord);
}

template <class T>
std::shared_ptr<dds::CdrReader<T>> Taps::TapService(const char* name, dds::Qos qos) {
  const auto reader =
      std::make_shared<dds::CdrReader<T>>(service_, name, qos, kFromServer<T> ? server_ : anyone_);
  const std::uint32_t channel = topics_.NumberOf(name, kTypeOf<T>);
  (kFromServer<T> ? drains_ : other_drains_).push_back([this, reader, channel] {
    Drain(*reader, channel);
  });
  return reader;
}

// Ends the readers first: their callbacks use the members declared before them.
Taps::~Taps() {
  sessions_.clear();
}

int Taps::sessions() const {
  int count = 0;
  for (const auto& [station, session] : sessions_) count += session.poses && session.wrenches;
  return count;
}

bool Taps::has_scene(const std::string& name) const {
  const auto scene = scenes_.find(name);
  return scene != scenes_.end() && bundles_.contains(scene->second);
}

bool Taps::IsWanted(const std::string& station) const {
  return wanted_.empty() || std::ranges::find(wanted_, station) != wanted_.end();
}

template <class T>
void Taps::Drain(dds::CdrReader<T>& reader, std::uint32_t channel) {
  T sample{};
  constexpr bool kOfAStation = requires {
    sample.station;
  };
  dds::CdrSample raw;
  while (reader.Take(raw, sample)) {
    if constexpr (kFromServer<T>) {
      if (origin_ == 0) {
        origin_ = raw.origin;
        server_->Only(origin_);
      }
      // The first sample of a stranger's writer, before which nobody knows whose it is.
      if (!server_->Allows(raw.origin)) continue;
      heard_ = true;
      if (raw.origin == origin_) {
        spoke_ns_ = now_ns_;
        is_silent_ = false;
      }
    }
    if constexpr (kOfAStation) {
      if (!IsWanted(sample.station)) continue;
    }
    if (!queue_.Put(channel, RecordingTime_ns, raw.cdr)) {
      topics_[channel].dropped.fetch_add(1, std::memory_order_relaxed);
    }
    if constexpr (std::is_same_v<T, wire::SessionState>) OnState(sample, raw.origin, now_ns_);
    if constexpr (std::is_same_v<T, wire::SceneBundle>) {
      scenes_[sample.scene] = sample.hash;
      if (sample.bundle._length > 0) bundles_.insert(sample.hash);
    }
  }
  dds::FreeContents(sample);
}

template <class T>
void Taps::Tap(dds::Reader<T>& reader, const std::string& name) {
  // Over shared memory, a reader made before it has discovered the writer leaks chunks for good.
  if (reader || !dds::WriterDiscovered(*loop_, name)) return;
  const std::uint32_t channel = topics_.NumberOf(name, kTypeOf<T>);
  TappedTopic* const tapped = &topics_[channel];
  reader = {*loop_, name, dds::Qos::kRecord, [this, channel, tapped](const T& sample) {
              // The struct is its own CDR payload (common/dds/wire.h).
              const std::span payload(reinterpret_cast<const std::uint8_t*>(&sample),
                                      sizeof sample);
              if (!queue_.Put(channel, RecordingTime_ns, kCdrHead, payload)) {
                tapped->dropped.fetch_add(1, std::memory_order_relaxed);
              }
            }};
}

void Taps::OnState(const wire::SessionState& state, std::uint64_t origin, std::int64_t now_ns) {
  // No server gives a session to a station with another name, and a topic's name contains it.
  if (!loop_ || state.phase == palpate_SESSION_REFUSED || !dds::IsStationName(state.station))
    return;
  const auto it = sessions_.find(state.station);
  if (state.phase == palpate_SESSION_ENDED) {
    if (it != sessions_.end() && it->second.run == state.run) it->second.ended_ns = now_ns;
    return;
  }
  Session& session = sessions_[state.station];
  if (session.run != state.run) session = {};
  session.run = state.run;
  session.origin = origin;
  if (state.phase == palpate_SESSION_ACTIVE && session.active_ns == 0) session.active_ns = now_ns;
}

void Taps::Succeed() {
  if (now_ns_ - looked_ns_ < kLook_ns) return;
  looked_ns_ = now_ns_;
  is_silent_ = is_silent_ || std::ranges::any_of(sessions_, [&](const auto& entry) {
                 const Session& session = entry.second;
                 return session.origin == origin_ && session.active_ns != 0 &&
                        session.ended_ns == 0 &&
                        now_ns_ - std::max(spoke_ns_, session.active_ns) > kSilent_ns;
               });
  const bool is_gone = is_silent_ && now_ns_ - spoke_ns_ > kGone_ns;
  if (origin_ != 0 && !is_gone && states_->Hears(origin_)) {
    return server_->Only(is_silent_ ? 0 : origin_);
  }
  is_silent_ = false;
  origin_ = 0;
  server_->Only(0);
  // What the other has said so far was dropped; new readers receive it again.
  if (server_->TakeRefused()) TapServer();
}

void Taps::Poll(std::int64_t now_ns) {
  now_ns_ = now_ns;
  Succeed();
  for (const auto& drain : drains_) drain();
  for (const auto& drain : other_drains_) drain();

  for (auto it = sessions_.begin(); it != sessions_.end();) {
    Session& session = it->second;
    if (session.ended_ns != 0 && now_ns - session.ended_ns > kLinger_ns) {
      it = sessions_.erase(it);
      continue;
    }
    if (session.ended_ns == 0) {
      Tap(session.poses, dds::PoseTopic(it->first, session.run));
      Tap(session.wrenches, dds::WrenchTopic(it->first, session.run));
    }
    ++it;
  }
}

}  // namespace palpate
