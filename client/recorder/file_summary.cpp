#include "client/recorder/file_summary.h"

#include <algorithm>
#include <ctime>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>

#include "common/files/output.h"
#include "common/text/hex16.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

std::string TimeText(std::int64_t ns) {
  return fmt::format("{:%F %T} UTC", fmt::gmtime(std::time_t{ns / 1'000'000'000}));
}

}  // namespace

std::string ToText(const FileSummary& summary) {
  std::string verdict = summary.verdict();
  if (!summary.intact()) std::ranges::transform(verdict, verdict.begin(), ::toupper);
  std::string text = fmt::format(
      "{}{}: {}\n", Printable(summary.files.front()),
      summary.files.size() > 1 ? fmt::format(" and {} more", summary.files.size() - 1) : "",
      verdict);
  if (const auto stations = summary.about.find("stations"); stations != summary.about.end()) {
    text += "  of no station but " + Printable(stations->second) + "\n";
  }
  if (!summary.end_reason.empty()) text += "  ended: " + Printable(summary.end_reason) + "\n";
  text += fmt::format("  {:.1f} s from {}, {} messages, {:.2f} MB ({:.3f} MB/s), palpate {}{}\n",
                      summary.duration_s, TimeText(summary.first_ns), summary.messages,
                      1e-6 * static_cast<double>(summary.bytes),
                      summary.duration_s > 0.0
                          ? 1e-6 * static_cast<double>(summary.bytes) / summary.duration_s
                          : 0.0,
                      summary.build.empty() ? "of an unknown build" : Printable(summary.build),
                      summary.physics.empty() ? "" : ", physics " + Printable(summary.physics));
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
    text += fmt::format("  {} {} sent no poses during the recording\n", before,
                        before == 1 ? "session" : "sessions");
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
                              {"physics", summary.physics},
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
