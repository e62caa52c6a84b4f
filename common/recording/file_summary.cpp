#include "common/recording/file_summary.h"

#include <algorithm>
#include <iterator>

#include "common/dds/cdr_reader.h"
#include "common/dds/topics.h"
#include "common/error.h"
#include "common/files/bundle_hash.h"
#include "common/recording/split_name.h"
#include "common/step_fault.h"
#include "common/text/hex16.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

std::string Value(const mcap::StringMap& map, const std::string& key) {
  const auto it = map.find(key);
  return it == map.end() ? "" : it->second;
}

/// No topic has a higher rate (a loop runs at most at 4 kHz).  Samples kept for late joiners arrive
/// all at once, and give no rate.
constexpr double kMostHz = 10'000.0;

}  // namespace

std::uint64_t FileSummary::Topic::before() const {
  const bool counts_from_1 = type == SchemaName(RecordedType::kWrench);
  return counts_from_1 && sequence.first() > 1 ? sequence.first() - 1 : 0;
}

const char* FileSummary::verdict() const {
  if (damaged) return "damaged";
  if (!complete) return "cut off";
  return whole() ? "whole" : "incomplete";
}

bool FileSummary::whole() const {
  const auto begins_late = [](const auto& topic) { return topic.second.before() > 0; };
  return intact() && problems.empty() && missing + dropped + no_channel + unknown == 0 &&
         std::ranges::none_of(topics, begins_late);
}

/// Gets the sample's own sequence number, or a count.  Returns false if its bytes are not of
/// its type.
bool FileSummary::Look(const RecordedSample& sample, std::uint64_t& sequence) {
  switch (sample.type) {
    case RecordedType::kHapticPose: {
      wire::HapticPose pose;
      if (!sample.To(pose)) return false;
      sequence = pose.pose_sequence;
      return true;
    }
    case RecordedType::kWrench: {
      wire::Wrench wrench;
      if (!sample.To(wrench)) return false;
      if ((wrench.faults & kFaultNotStarted) == 0) {
        first_forces_.try_emplace(*sample.topic, wrench.pose_sequence);
      }
      sequence = wrench.answer;
      return true;
    }
    case RecordedType::kSessionState: {
      wire::SessionState state{};
      if (!sample.To(state)) return false;
      if (state.phase == palpate_SESSION_REFUSED) return true;
      const auto [it, is_new] = places_.try_emplace({state.station, state.run}, sessions.size());
      if (is_new) {
        sessions.push_back({state.station, state.scene, state.tool, state.run, 0, 0});
      }
      std::uint64_t& start = sessions[it->second].start_sequence;
      start = std::max<std::uint64_t>(start, state.start_sequence);
      return true;
    }
    case RecordedType::kSceneBundle: {
      dds::Owned<wire::SceneBundle> owned;
      const wire::SceneBundle& bundle = owned.value;
      if (!sample.To(owned.value)) return false;
      scenes[bundle.scene] = {Hex16(bundle.hash), true};
      if (bundle.bundle._length == 0) return true;  // a seat: the bundle is that of another scene
      try {
        CheckBundleHash({bundle.bundle._buffer, bundle.bundle._length}, bundle.hash,
                        "scene " + Quoted(bundle.scene));
      } catch (const Error& error) {
        problems.push_back(error.what());
        damaged = true;
      }
      return true;
    }
    default:
      return true;
  }
}

void FileSummary::Add(const RecordedSample& sample) {
  Topic& topic = topics[*sample.topic];
  std::uint64_t sequence = topic.messages + 1;
  if (topic.messages == 0) {
    topic.type = SchemaName(sample.type);
    topic.first_ns = sample.log_time_ns;
  }
  if (messages == 0) first_ns = sample.log_time_ns;
  ++messages;
  ++topic.messages;
  topic.bytes += sample.cdr.size();
  topic.last_ns = std::max(topic.last_ns, sample.log_time_ns);
  last_ns_ = std::max(last_ns_, sample.log_time_ns);
  if (Look(sample, sequence)) {
    topic.sequence.Add(sequence);
  } else {
    ++topic.broken;
  }
}

void FileSummary::Finish(const RecordingReader& reader) {
  bytes = reader.bytes();
  duration_s = 1e-9 * static_cast<double>(last_ns_ - first_ns);
  complete = reader.complete();
  damaged = damaged || reader.damaged();
  std::ranges::copy(reader.problems(), std::back_inserter(problems));
  unknown = reader.unknown();
  for (const mcap::Metadata& metadata : reader.metadata()) {
    const mcap::StringMap& values = metadata.values;
    if (metadata.name == kRecordingRecord) about = values;
    build = Value(about, "build");
    physics = Value(about, "physics");
    if (metadata.name == "palpate.end") end_reason = Value(values, "reason");
    if (metadata.name == "palpate.topic") {
      const auto count = [&](const std::string& key) {
        const auto said = CountIn(values, key);
        if (said) return *said;
        problems.push_back("its recorder's figure is no count: " + key + ' ' +
                           Quoted(values.at(key)));
        damaged = true;
        return std::uint64_t{0};
      };
      const std::uint64_t dropped = count("dropped");
      const std::string name = Value(values, "topic");
      no_channel += count("no_channel");
      // The topic has no message if all of its samples were dropped.
      if (dropped > 0) topics[name].type = Value(values, "type");
      if (const auto it = topics.find(name); it != topics.end()) {
        it->second.dropped = dropped;
      }
    }
    if (metadata.name == "palpate.scene") {
      scenes.try_emplace(Value(values, "scene"), Scene{Value(values, "hash"), false});
    }
  }
  for (Session& session : sessions) {
    const auto poses = topics.find(dds::PoseTopic(session.station, session.run));
    if (poses != topics.end()) session.poses = poses->second.messages;
    if (session.start_sequence != 0) continue;
    // The recording may end before the server has told with which pose forces began.
    const auto began = first_forces_.find(dds::WrenchTopic(session.station, session.run));
    if (began != first_forces_.end()) session.start_sequence = began->second;
  }
  for (auto& [name, topic] : topics) {
    const double span_s = 1e-9 * static_cast<double>(topic.last_ns - topic.first_ns);
    const double rate_hz = static_cast<double>(topic.messages - 1) / span_s;
    if (topic.messages > 1 && rate_hz <= kMostHz) topic.rate_hz = rate_hz;
    missing += topic.sequence.missing();
    dropped += topic.dropped;
    broken += topic.broken;
    astray += topic.sequence.astray();
  }
  damaged = damaged || broken + astray > 0;
}

FileSummary Summarise(const std::vector<std::string>& files) {
  FileSummary summary;
  summary.files = files;
  RecordingReader reader(files);
  for (RecordedSample sample{}; reader.Next(sample);) summary.Add(sample);
  summary.Finish(reader);
  return summary;
}

}  // namespace palpate
