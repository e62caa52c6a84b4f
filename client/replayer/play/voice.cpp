#include "client/replayer/play/voice.h"

#include <chrono>
#include <type_traits>

#include <spdlog/spdlog.h>

#include "common/dds/cdr.h"
#include "common/dds/cdr_reader.h"
#include "common/dds/phase_name.h"
#include "common/dds/random_run.h"
#include "common/realtime/steady_clock.h"

namespace palpate {
namespace {

/// DDS drops a viewer that has sent nothing for 10 s; until then a stopped viewer may delay
/// the others.
constexpr std::int64_t kPatience_ns = 15'000'000'000;
constexpr std::int64_t kNotice_ns = 1'000'000'000;
constexpr std::chrono::milliseconds kBetweenWrites{5};

}  // namespace

Voice::Round::Round(const dds::Participant& service)
    : states(service, dds::kSessionStateTopic, dds::Qos::kSession),
      blocks(service, dds::kSolidBlockTopic, dds::Qos::kSession),
      wholes(service, dds::kSceneWholeTopic, dds::Qos::kSession),
      bundles(service, dds::kSceneBundleTopic, dds::Qos::kSession) {}

Voice::Voice(const dds::Participant& service, StopSignal& stop)
    : service_(service),
      stop_(stop),
      tools_(service, dds::kToolStateTopic, dds::Qos::kStream),
      moved_(service, dds::kMovedStateTopic, dds::Qos::kStream),
      statistics_(service, dds::kLoopStatisticsTopic, dds::Qos::kStream),
      stations_(service, dds::kStationStatisticsTopic, dds::Qos::kStream) {}

void Voice::BeginRound() {
  run_ = RandomRun();
  lacks_ = false;
  standing_.clear();
  round_.emplace(service_);
}

bool Voice::Say(RecordedType type, std::span<const std::uint8_t> cdr) {
  switch (type) {
    case RecordedType::kSessionState:
      return Say(cdr, round_->states, true);
    case RecordedType::kSolidBlock:
      return Say(cdr, round_->blocks, true);
    case RecordedType::kSceneWhole:
      return Say(cdr, round_->wholes, true);
    case RecordedType::kSceneBundle:
      return Say(cdr, round_->bundles, true);
    case RecordedType::kToolState:
      return Say(cdr, tools_, false);
    case RecordedType::kMovedState:
      return Say(cdr, moved_, false);
    case RecordedType::kLoopStatistics:
      return Say(cdr, statistics_, false);
    case RecordedType::kStationStatistics:
      return Say(cdr, stations_, false);
    default:
      return true;
  }
}

void Voice::EndSessions(const std::string& reason) {
  for (auto& [station, state] : standing_) {
    state.phase = palpate_SESSION_ENDED;
    wire::FromText(reason, state.reason);
    round_->states.Write(state);
  }
  standing_.clear();
}

template <class T>
bool Voice::Say(std::span<const std::uint8_t> cdr, dds::Writer<T>& writer, bool stays) {
  T value{};
  bool said = true;
  if (dds::FromCdr(cdr, value)) {
    // Keeps the recorded servers' runs distinct.  Viewers ignore runs that they know to be over.
    if constexpr (requires { value.server_run; }) value.server_run += run_;
    if (stays) {
      said = Insist(writer, value);
    } else {
      writer.Write(value);
    }
    if constexpr (std::is_same_v<T, wire::SessionState>) Keep(value);
  }
  dds::FreeContents(value);
  return said;
}

/// Repeats a write until DDS accepts it, for at most kPatience_ns; returns false if the replay is
/// stopped.  A write waits up to 100 ms for viewers to take earlier samples and is then refused,
/// for instance when many changes come at once, or a viewer has stopped.
template <class T>
bool Voice::Insist(dds::Writer<T>& writer, const T& value) {
  if (writer.Write(value)) return true;
  const std::int64_t begun_ns = SteadyNanoseconds();
  bool noted = false;
  while (!writer.Write(value)) {
    const std::int64_t waited_ns = SteadyNanoseconds() - begun_ns;
    if (waited_ns > kNotice_ns && !noted) {
      noted = true;
      spdlog::warn("a viewer does not read its messages: the replay waits for it");
    }
    if (waited_ns > kPatience_ns) {
      if (!lacks_) {
        spdlog::error(
            "viewers did not read a message for {} s, and their picture may lack something; a seek "
            "or the next repetition completes it",
            kPatience_ns / 1'000'000'000);
      }
      lacks_ = true;
      return true;
    }
    if (stop_.WaitFor(kBetweenWrites)) return false;
  }
  return true;
}

void Voice::Keep(const wire::SessionState& state) {
  if (IsOver(state)) {
    standing_.erase(state.station);
  } else {
    standing_[state.station] = state;
  }
}

}  // namespace palpate
