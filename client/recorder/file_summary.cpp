#include "client/recorder/file_summary.h"

#include <algorithm>
#include <cctype>
#include <ctime>
#include <iterator>
#include <utility>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>

#include "common/dds/cdr_reader.h"
#include "common/dds/topics.h"
#include "common/error.h"
#include "common/files/bundle_hash.h"
#include "common/files/output.h"
#include "common/recording/recording_reader.h"
#include "common/text/hex16.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

std::string Value(const mcap::StringMap& map, const std::string& key) {
  const auto it = map.find(key);
  return it == map.end() ? "" : it->second;
}

/// More often nothing is sent (a loop runs at most at 4 kHz): what is kept for those who come late
/// reaches them all at once, and has no rate.
constexpr double kMostHz = 10'000.0;

using SessionKey = std::pair<std::string, std::uint64_t>;  // station, run

/// The number that the sample gives itself, or a count.  False where its bytes are not of its type.
/// @param place  of each session in the summary.
bool Look(const RecordedSample& sample, FileSummary& summary,
          std::map<SessionKey, std::size_t>& place, std::uint64_t& sequence) {
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
      sequence = wrench.answer;
      return true;
    }
    case RecordedType::kSessionState: {
      wire::SessionState state{};
      if (!sample.To(state)) return false;
      if (state.phase == palpate_SESSION_REFUSED) return true;
      const auto [it, is_new] =
          place.try_emplace({state.station, state.run}, summary.sessions.size());
      if (is_new) {
        summary.sessions.push_back({state.station, state.scene, state.tool, state.run, 0, 0});
      }
      std::uint64_t& start = summary.sessions[it->second].start_sequence;
      start = std::max<std::uint64_t>(start, state.start_sequence);
      return true;
    }
    case RecordedType::kSceneBundle: {
      dds::Owned<wire::SceneBundle> owned;
      const wire::SceneBundle& bundle = owned.value;
      if (!sample.To(owned.value)) return false;
      summary.scenes[bundle.scene] = {Hex16(bundle.hash), true};
      try {
        CheckBundleHash({bundle.bundle._buffer, bundle.bundle._length}, bundle.hash,
                        "scene " + Quoted(bundle.scene));
      } catch (const Error& error) {
        summary.problems.push_back(error.what());
        summary.damaged = true;
      }
      return true;
    }
    default:
      return true;
  }
}

std::string TimeText(std::int64_t ns) {
  return fmt::format("{:%F %T} UTC", fmt::gmtime(std::time_t{ns / 1'000'000'000}));
}

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

FileSummary Summarise(const std::vector<std::string>& files) {
  FileSummary summary;
  summary.files = files;
  RecordingReader reader(files);
  RecordedSample sample{};
  std::map<SessionKey, std::size_t> place;
  std::int64_t last_ns = 0;
  while (reader.Next(sample)) {
    FileSummary::Topic& topic = summary.topics[*sample.topic];
    std::uint64_t sequence = topic.messages + 1;
    if (topic.messages == 0) {
      topic.type = SchemaName(sample.type);
      topic.first_ns = sample.log_time_ns;
    }
    if (summary.messages == 0) summary.first_ns = sample.log_time_ns;
    ++summary.messages;
    ++topic.messages;
    topic.bytes += sample.cdr.size();
    topic.last_ns = std::max(topic.last_ns, sample.log_time_ns);
    last_ns = std::max(last_ns, sample.log_time_ns);
    if (Look(sample, summary, place, sequence)) {
      topic.sequence.Add(sequence);
    } else {
      ++topic.broken;
    }
  }
  summary.bytes = reader.bytes();
  summary.duration_s = 1e-9 * static_cast<double>(last_ns - summary.first_ns);
  summary.complete = reader.complete();
  summary.damaged = summary.damaged || reader.damaged();
  std::ranges::copy(reader.problems(), std::back_inserter(summary.problems));
  summary.unknown = reader.unknown();
  for (const mcap::Metadata& metadata : reader.metadata()) {
    const mcap::StringMap& values = metadata.values;
    if (metadata.name == "palpate.recording") {
      summary.build = Value(values, "build");
      summary.stations = Value(values, "stations");
    }
    if (metadata.name == "palpate.end") summary.end_reason = Value(values, "reason");
    if (metadata.name == "palpate.topic") {
      const auto count = [&](const std::string& key) {
        const auto said = CountIn(values, key);
        if (said) return *said;
        summary.problems.push_back("its recorder's figure is no count: " + key + ' ' +
                                   Quoted(values.at(key)));
        summary.damaged = true;
        return std::uint64_t{0};
      };
      const std::uint64_t dropped = count("dropped");
      const std::string name = Value(values, "topic");
      summary.no_channel += count("no_channel");
      // Without a single message where all of its samples were dropped.
      if (dropped > 0) summary.topics[name].type = Value(values, "type");
      if (const auto it = summary.topics.find(name); it != summary.topics.end()) {
        it->second.dropped = dropped;
      }
    }
    if (metadata.name == "palpate.scene") {
      summary.scenes.try_emplace(Value(values, "scene"),
                                 FileSummary::Scene{Value(values, "hash"), false});
    }
  }
  for (FileSummary::Session& session : summary.sessions) {
    const auto poses = summary.topics.find(dds::PoseTopic(session.station, session.run));
    if (poses != summary.topics.end()) session.poses = poses->second.messages;
  }
  for (auto& [name, topic] : summary.topics) {
    const double span_s = 1e-9 * static_cast<double>(topic.last_ns - topic.first_ns);
    const double rate_hz = static_cast<double>(topic.messages - 1) / span_s;
    if (topic.messages > 1 && rate_hz <= kMostHz) topic.rate_hz = rate_hz;
    summary.missing += topic.sequence.missing();
    summary.dropped += topic.dropped;
    summary.broken += topic.broken;
    summary.astray += topic.sequence.astray();
  }
  summary.damaged = summary.damaged || summary.broken + summary.astray > 0;
  return summary;
}

std::string ToText(const FileSummary& summary) {
  std::string verdict = summary.verdict();
  if (!summary.intact()) std::ranges::transform(verdict, verdict.begin(), ::toupper);
  std::string text = fmt::format(
      "{}{}: {}\n", Printable(summary.files.front()),
      summary.files.size() > 1 ? fmt::format(" and {} more", summary.files.size() - 1) : "",
      verdict);
  if (!summary.stations.empty()) {
    text += "  of no station but " + Printable(summary.stations) + "\n";
  }
  if (!summary.end_reason.empty()) text += "  ended: " + Printable(summary.end_reason) + "\n";
  text += fmt::format(
      "  {:.1f} s from {}, {} messages, {:.2f} MB ({:.3f} MB/s), palpate {}\n", summary.duration_s,
      TimeText(summary.first_ns), summary.messages, 1e-6 * static_cast<double>(summary.bytes),
      summary.duration_s > 0.0 ? 1e-6 * static_cast<double>(summary.bytes) / summary.duration_s
                               : 0.0,
      summary.build.empty() ? "of an unknown build" : Printable(summary.build));
  for (const auto& [name, scene] : summary.scenes) {
    text += fmt::format("  scene {}: hash {}, {}\n", Printable(name), Printable(scene.hash),
                        scene.bundle ? "itself in the recording" : "not in the recording");
  }
  std::size_t before = 0;
  for (const FileSummary::Session& session : summary.sessions) {
    if (session.poses == 0) {
      ++before;
      continue;
    }
    text += fmt::format(
        "  station {} (run {}): tool {} of scene {}, {}\n", Printable(session.station),
        Hex16(session.run), Printable(session.tool), Printable(session.scene),
        session.start_sequence == 0 ? "no forces"
                                    : fmt::format("forces from pose {}", session.start_sequence));
  }
  if (before > 0) {
    text += fmt::format("  {} {} told of that had no poses while this was recorded\n", before,
                        before == 1 ? "session is" : "sessions are");
  }
  text += fmt::format("\n  {:<52} {:>9} {:>8} {:>8} {:>8} {:>9}\n", "topic", "messages", "Hz",
                      "missing", "dropped", "MB raw");
  for (const auto& [name, topic] : summary.topics) {
    text += fmt::format(
        "  {:<52} {:>9} {:>8} {:>8} {:>8} {:>9.3f}\n", Printable(name), topic.messages,
        topic.rate_hz > 0.0 ? fmt::format("{:.1f}", topic.rate_hz) : "-", topic.sequence.missing(),
        topic.dropped, 1e-6 * static_cast<double>(topic.bytes));
    if (topic.broken > 0) {
      text += fmt::format("  {:<52} {} of them are not of type {}\n", "", topic.broken,
                          Printable(topic.type));
    }
    if (topic.before() > 0) {
      text += fmt::format("  {:<52} begins with answer {}: cannot be verified from here on alone\n",
                          "", topic.sequence.first());
    }
  }
  text += "\n";
  if (summary.whole()) text += "  nothing is missing\n";
  const auto say = [&](std::uint64_t count, const char* what) {
    if (count > 0) text += fmt::format("  {} samples {}\n", count, what);
  };
  say(summary.missing, "are missing, by the numbers of those before and after");
  say(summary.dropped, "came and were dropped by the recorder: its disk was too slow");
  say(summary.no_channel,
      "came and were left out: an MCAP file holds 65535 topics, and theirs came later");
  say(summary.broken, "are not of their type");
  say(summary.astray, "have numbers that do not go on from those before");
  say(summary.unknown, "are of types that this version does not know");
  for (const std::string& problem : summary.problems) text += "  " + Printable(problem) + "\n";
  return text;
}

void WriteJson(const FileSummary& summary, const std::string& file) {
  nlohmann::ordered_json json{{"files", summary.files},
                              {"verdict", summary.verdict()},
                              {"complete", summary.complete},
                              {"ended", summary.end_reason},
                              {"build", summary.build},
                              {"bytes", summary.bytes},
                              {"duration_s", summary.duration_s},
                              {"first_ns", summary.first_ns},
                              {"messages", summary.messages},
                              {"missing", summary.missing},
                              {"dropped", summary.dropped},
                              {"no_channel", summary.no_channel},
                              {"broken", summary.broken},
                              {"astray", summary.astray},
                              {"unknown", summary.unknown},
                              {"whole", summary.whole()},
                              {"problems", summary.problems},
                              {"scenes", nlohmann::ordered_json::array()},
                              {"sessions", nlohmann::ordered_json::array()},
                              {"topics", nlohmann::ordered_json::array()}};
  for (const auto& [name, scene] : summary.scenes) {
    json["scenes"].push_back({{"scene", name}, {"hash", scene.hash}, {"bundle", scene.bundle}});
  }
  for (const FileSummary::Session& session : summary.sessions) {
    json["sessions"].push_back({{"station", session.station},
                                {"run", Hex16(session.run)},
                                {"scene", session.scene},
                                {"tool", session.tool},
                                {"start_sequence", session.start_sequence},
                                {"poses", session.poses}});
  }
  for (const auto& [name, topic] : summary.topics) {
    json["topics"].push_back({{"topic", name},
                              {"type", topic.type},
                              {"messages", topic.messages},
                              {"rate_hz", topic.rate_hz},
                              {"bytes", topic.bytes},
                              {"first", topic.sequence.first()},
                              {"last", topic.sequence.last()},
                              {"holes", topic.sequence.holes()},
                              {"missing", topic.sequence.missing()},
                              {"before", topic.before()},
                              {"dropped", topic.dropped},
                              {"broken", topic.broken}});
  }
  WriteOutput("--json", file,
              json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

}  // namespace palpate
