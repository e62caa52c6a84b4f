#include "client/replayer/export/methods.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <string_view>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>

#include "common/dds/topics.h"
#include "common/revision.h"
#include "common/text/hex16.h"
#include "common/text/joined.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

/// For what recorders of earlier versions did not write.
constexpr const char* kNotRecorded = "not recorded";

std::string Value(const mcap::StringMap& map, const std::string& key) {
  const auto it = map.find(key);
  return it == map.end() ? kNotRecorded : it->second;
}

std::string TimeText(std::int64_t ns) {
  return fmt::format("{:%FT%TZ}", fmt::gmtime(std::time_t{ns / 1'000'000'000}));
}

/// JSON has no NaN and no infinity.
nlohmann::ordered_json Finite(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

/// Returns a cell of a Markdown table: text without markup.
std::string Cell(const std::string& text) {
  std::string cell;
  for (const char c : Printable(text)) {
    if (c == '<' || c == '>' || c == '&') {
      cell += c == '<' ? "&lt;" : c == '>' ? "&gt;" : "&amp;";
    } else {
      if (std::string_view("\\`*_~|[]!").find(c) != std::string_view::npos) cell += '\\';
      cell += c;
    }
  }
  return cell;
}

}  // namespace

Methods::Session& Methods::SessionOf(const std::string& station, std::uint64_t run) {
  const auto [it, is_new] = places_.try_emplace({station, run}, sessions_.size());
  if (is_new) {
    sessions_.emplace_back();
    sessions_.back().station = station;
    sessions_.back().run = run;
  }
  return sessions_[it->second];
}

void Methods::Add(const RecordedSample& sample) {
  all_.Add(sample);
  wire::SessionRequest request{};
  wire::SessionState state{};
  wire::StationStatistics station{};
  if (sample.To(request)) {
    if (!request.leave) SessionOf(request.station, request.run).device = request.device;
  } else if (sample.To(state)) {
    Session& session = SessionOf(state.station, state.run);
    session.scene = state.scene;
    session.tool = state.tool;
    session.stiffness_N_per_m = std::max(session.stiffness_N_per_m, state.stiffness_N_per_m);
    session.torsional_stiffness_Nm_per_rad =
        std::max(session.torsional_stiffness_Nm_per_rad, state.torsional_stiffness_Nm_per_rad);
    session.forces = session.forces || state.start_sequence != 0;
  } else if (sample.To(station)) {
    Session& session = SessionOf(station.station, station.run);
    session.device = station.device;
    ++session.limiter_periods;
    session.wanted_force_N = std::max(session.wanted_force_N, station.wanted_force_N_max);
    session.wanted_torque_Nm = std::max(session.wanted_torque_Nm, station.wanted_torque_Nm_max);
    session.applied_force_N = std::max(session.applied_force_N, station.applied_force_N_max);
    session.applied_torque_Nm = std::max(session.applied_torque_Nm, station.applied_torque_Nm_max);
    auto& calls = session.limiter_calls;
    calls["nonfinite"] += station.nonfinite;
    calls["clamped"] += station.clamped;
    calls["slewed"] += station.slewed;
    calls["braked"] += station.braked;
    calls["warm"] += station.warm;
    calls["faded"] += station.faded;
    calls["disabled"] += station.disabled;
  } else if (sample.type == RecordedType::kSessionRequest ||
             sample.type == RecordedType::kStationStatistics) {
    ++all_.topics[*sample.topic].broken;
  }
}

std::string Methods::ToJson(const std::vector<std::string>& recording,
                            const std::vector<std::string>& files) const {
  using Json = nlohmann::ordered_json;
  Json json{{"made_by", kExportMaker},
            {"palpate",
             {{"recorded_with", Value(all_.about, "build")},
              {"recorded_physics", all_.physics},
              {"exported_with", PALPATE_VERSION},
              {"exported_physics", kPhysicsRevision}}},
            {"recording", recording},
            {"begun", TimeText(all_.first_ns)},
            {"begun_ns", all_.first_ns},
            {"duration_s", all_.duration_s},
            {"complete", all_.complete},
            {"ended", all_.end_reason},
            {"problems", all_.problems},
            {"machine",
             {{"cpu", Value(all_.about, "cpu")},
              {"cores", Value(all_.about, "cores")},
              {"kernel", Value(all_.about, "kernel")}}},
            {"transport", Value(all_.about, "loop")},
            {"samples",
             {{"missing", all_.missing},
              {"dropped_by_recorder", all_.dropped},
              {"broken", all_.broken},
              {"astray", all_.astray},
              {"unknown_type", all_.unknown},
              {"left_out", left_out_}}},
            {"scenes", Json::array()},
            {"sessions", Json::array()},
            {"topics", Json::array()},
            {"files", files}};
  for (const auto& [name, scene] : all_.scenes)
    json["scenes"].push_back({{"scene", name}, {"hash", scene.hash}});
  for (const Session& s : sessions_) {
    json["sessions"].push_back(
        {{"station", s.station},
         {"run", Hex16(s.run)},
         {"folder", s.folder},
         {"scene", s.scene},
         {"tool", s.tool},
         {"device", s.device},
         {"forces", s.forces},
         {"spring",
          {{"stiffness_N_per_m", Finite(s.stiffness_N_per_m)},
           {"torsional_stiffness_Nm_per_rad", Finite(s.torsional_stiffness_Nm_per_rad)}}},
         {"limiter",
          {{"periods", s.limiter_periods},
           {"wanted_force_max_N", Finite(s.wanted_force_N)},
           {"wanted_torque_max_Nm", Finite(s.wanted_torque_Nm)},
           {"applied_force_max_N", Finite(s.applied_force_N)},
           {"applied_torque_max_Nm", Finite(s.applied_torque_Nm)},
           {"calls", s.limiter_calls}}}});
  }
  for (const auto& [name, topic] : all_.topics) {
    json["topics"].push_back({{"topic", name},
                              {"samples", topic.messages},
                              {"rate_Hz", topic.rate_hz},
                              {"missing", topic.sequence.missing()},
                              {"dropped_by_recorder", topic.dropped}});
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string Methods::ToMarkdown(const std::vector<std::string>& recording) const {
  std::string text =
      "# Methods\n\nWhat a paper's methods section needs of this recording; the same for programs "
      "is in `methods.json`.\n\n| | |\n|---|---|\n";
  const auto line = [&](const char* what, const std::string& value) {
    text += fmt::format("| {} | {} |\n", what, Cell(value));
  };
  line("recording", Joined(recording));
  line("begun", TimeText(all_.first_ns));
  line("length", fmt::format("{:.3f} s{}", all_.duration_s, all_.complete ? "" : ", cut off"));
  line("recorded with", "palpate " + Value(all_.about, "build") + ", physics " +
                            (all_.physics.empty() ? "not told" : all_.physics));
  line("exported with", std::string("palpate " PALPATE_VERSION ", physics ") + kPhysicsRevision);
  line("recorder's machine", Value(all_.about, "cpu") + ", " + Value(all_.about, "cores") +
                                 " cores, kernel " + Value(all_.about, "kernel"));
  line("transport of poses and wrenches", Value(all_.about, "loop"));
  line("samples missing, by their numbers", std::to_string(all_.missing));
  line("samples dropped by the recorder", std::to_string(all_.dropped));
  line("samples that are not of their type", std::to_string(all_.broken));
  if (all_.astray > 0) {
    line("samples with numbers that do not go on from those before", std::to_string(all_.astray));
  }
  if (left_out_ > 0) line("samples left out, of no station", std::to_string(left_out_));
  for (const std::string& problem : all_.problems) line("problem", problem);
  text += "\n## Scenes\n\n| scene | hash (XXH3 of its bundle) |\n|---|---|\n";
  for (const auto& [name, scene] : all_.scenes) {
    text += fmt::format("| {} | {} |\n", Cell(name), Cell(scene.hash));
  }
  text +=
      "\n## Sessions\n\n| station | run | scene | tool | device | spring | pose rate | wrench rate "
      "| missing | largest force wanted, applied | limiter: calls "
      "|\n|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const Session& s : sessions_) {
    const auto find = [&](const std::string& topic) {
      const auto it = all_.topics.find(topic);
      return it == all_.topics.end() ? FileSummary::Topic{} : it->second;
    };
    const FileSummary::Topic poses = find(dds::PoseTopic(s.station, s.run)),
                             wrenches = find(dds::WrenchTopic(s.station, s.run));
    std::string calls;
    for (const auto& [stage, count] : s.limiter_calls) {
      if (count > 0) calls += fmt::format("{}{} {}", calls.empty() ? "" : ", ", stage, count);
    }
    text += fmt::format(
        "| {} | `{}` | {} | {} | {} | {:g} N/m, {:g} N m/rad | {:.1f} Hz | {:.1f} Hz | {} | {:.3f} "
        "N, {:.3f} N | {} |\n",
        Cell(s.station), Hex16(s.run), Cell(s.scene), Cell(s.tool), Cell(s.device),
        s.stiffness_N_per_m, s.torsional_stiffness_Nm_per_rad, poses.rate_hz, wrenches.rate_hz,
        poses.sequence.missing() + wrenches.sequence.missing(), s.wanted_force_N, s.applied_force_N,
        s.limiter_periods == 0 ? "not recorded"
        : calls.empty()        ? "none"
                               : calls);
  }
  return text +
         "\nThe limiter's bounds are those of the device's data sheet (Palpate's page \"Devices\" "
         "has them), tightened where the station was told so; a recording holds what was wanted "
         "and applied, and how often each stage acted.\n";
}

}  // namespace palpate
