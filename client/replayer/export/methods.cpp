#include "client/replayer/export/methods.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <string_view>

#include <nlohmann/json.hpp>
#include <spdlog/fmt/chrono.h>
#include <spdlog/fmt/fmt.h>

#include "common/dds/cdr_reader.h"
#include "common/dds/topics.h"
#include "common/text/hex16.h"
#include "common/text/quoted.h"

namespace palpate {
namespace {

/// What a recorder of before this version has not written.
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

/// A cell of a table in Markdown: text, in which nothing is markup.
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

double Methods::Topic::rate_Hz() const {
  const double span_s = 1e-9 * static_cast<double>(last_ns - first_ns);
  return samples > 1 && span_s > 0.0 ? static_cast<double>(samples - 1) / span_s : 0.0;
}

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
  if (!std::exchange(any_, true)) first_ns_ = sample.log_time_ns;
  last_ns_ = std::max(last_ns_, sample.log_time_ns);
  Topic& topic = topics_[*sample.topic];
  if (topic.samples++ == 0) topic.first_ns = sample.log_time_ns;
  topic.last_ns = std::max(topic.last_ns, sample.log_time_ns);

  wire::HapticPose pose;
  wire::Wrench wrench;
  wire::SessionRequest request{};
  wire::SessionState state{};
  wire::StationStatistics station{};
  switch (sample.type) {
    case RecordedType::kHapticPose:
      if (!sample.To(pose)) break;
      topic.sequence.Add(pose.pose_sequence);
      return;
    case RecordedType::kWrench:
      if (!sample.To(wrench)) break;
      topic.sequence.Add(wrench.answer);
      return;
    case RecordedType::kSessionRequest:
      if (!sample.To(request)) break;
      if (!request.leave) SessionOf(request.station, request.run).device = request.device;
      return;
    case RecordedType::kSessionState: {
      if (!sample.To(state)) break;
      Session& session = SessionOf(state.station, state.run);
      session.scene = state.scene;
      session.tool = state.tool;
      session.stiffness_N_per_m = std::max(session.stiffness_N_per_m, state.stiffness_N_per_m);
      session.torsional_stiffness_Nm_per_rad =
          std::max(session.torsional_stiffness_Nm_per_rad, state.torsional_stiffness_Nm_per_rad);
      session.forces = session.forces || state.start_sequence != 0;
      return;
    }
    case RecordedType::kStationStatistics: {
      if (!sample.To(station)) break;
      Session& session = SessionOf(station.station, station.run);
      session.device = station.device;
      ++session.limiter_periods;
      session.wanted_force_N = std::max(session.wanted_force_N, station.wanted_force_N_max);
      session.wanted_torque_Nm = std::max(session.wanted_torque_Nm, station.wanted_torque_Nm_max);
      session.applied_force_N = std::max(session.applied_force_N, station.applied_force_N_max);
      session.applied_torque_Nm =
          std::max(session.applied_torque_Nm, station.applied_torque_Nm_max);
      auto& calls = session.limiter_calls;
      calls["nonfinite"] += station.nonfinite;
      calls["clamped"] += station.clamped;
      calls["slewed"] += station.slewed;
      calls["braked"] += station.braked;
      calls["warm"] += station.warm;
      calls["faded"] += station.faded;
      calls["disabled"] += station.disabled;
      return;
    }
    case RecordedType::kSceneBundle: {
      dds::Owned<wire::SceneBundle> bundle;
      if (!sample.To(bundle.value)) break;
      scenes_[bundle.value.scene] = Hex16(bundle.value.hash);
      return;
    }
    default:
      return;
  }
  ++broken_;
}

void Methods::Finish(const RecordingReader& reader) {
  complete_ = reader.complete();
  problems_ = reader.problems();
  unknown_ = reader.unknown();
  for (const mcap::Metadata& metadata : reader.metadata()) {
    if (metadata.name == "palpate.recording") about_ = metadata.values;
    if (metadata.name == "palpate.end") end_ = Value(metadata.values, "reason");
    if (metadata.name == "palpate.scene") {
      scenes_.try_emplace(Value(metadata.values, "scene"), Value(metadata.values, "hash"));
    }
    if (metadata.name != "palpate.topic") continue;
    const std::uint64_t dropped = CountIn(metadata.values, "dropped").value_or(0);
    if (dropped > 0) topics_[Value(metadata.values, "topic")].dropped = dropped;
  }
}

double Methods::duration_s() const {
  return 1e-9 * static_cast<double>(last_ns_ - first_ns_);
}

Methods::Totals Methods::totals() const {
  Totals totals;
  for (const auto& [name, topic] : topics_) {
    totals.missing += topic.sequence.missing();
    totals.astray += topic.sequence.astray();
    totals.dropped += topic.dropped;
  }
  return totals;
}

std::string Methods::ToJson(const std::vector<std::string>& recording,
                            const std::vector<std::string>& files) const {
  using Json = nlohmann::ordered_json;
  const auto [missing, astray, dropped] = totals();
  Json json{
      {"made_by", kExportMaker},
      {"palpate", {{"recorded_with", Value(about_, "build")}, {"exported_with", PALPATE_VERSION}}},
      {"recording", recording},
      {"begun", TimeText(first_ns_)},
      {"begun_ns", first_ns_},
      {"duration_s", duration_s()},
      {"complete", complete_},
      {"ended", end_},
      {"problems", problems_},
      {"machine",
       {{"cpu", Value(about_, "cpu")},
        {"cores", Value(about_, "cores")},
        {"kernel", Value(about_, "kernel")}}},
      {"transport", Value(about_, "loop")},
      {"samples",
       {{"missing", missing},
        {"dropped_by_recorder", dropped},
        {"broken", broken_},
        {"astray", astray},
        {"unknown_type", unknown_},
        {"left_out", left_out_}}},
      {"scenes", Json::array()},
      {"sessions", Json::array()},
      {"topics", Json::array()},
      {"files", files}};
  for (const auto& [name, hash] : scenes_)
    json["scenes"].push_back({{"scene", name}, {"hash", hash}});
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
  for (const auto& [name, topic] : topics_) {
    json["topics"].push_back({{"topic", name},
                              {"samples", topic.samples},
                              {"rate_Hz", topic.rate_Hz()},
                              {"missing", topic.sequence.missing()},
                              {"dropped_by_recorder", topic.dropped}});
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string Methods::ToMarkdown(const std::vector<std::string>& recording) const {
  const auto [missing, astray, dropped] = totals();
  std::string text =
      "# Methods\n\nWhat a paper's methods section needs of this recording; the same "
      "for programs is in `methods.json`.\n\n| | |\n|---|---|\n";
  const auto line = [&](const char* what, const std::string& value) {
    text += fmt::format("| {} | {} |\n", what, Cell(value));
  };
  std::string names;
  for (const std::string& file : recording) names += (names.empty() ? "" : ", ") + file;
  line("recording", names);
  line("begun", TimeText(first_ns_));
  line("length", fmt::format("{:.3f} s{}", duration_s(), complete_ ? "" : ", cut off"));
  line("recorded with", "palpate " + Value(about_, "build"));
  line("exported with", "palpate " PALPATE_VERSION);
  line("recorder's machine", Value(about_, "cpu") + ", " + Value(about_, "cores") +
                                 " cores, kernel " + Value(about_, "kernel"));
  line("transport of poses and wrenches", Value(about_, "loop"));
  line("samples missing, by their numbers", std::to_string(missing));
  line("samples dropped by the recorder", std::to_string(dropped));
  line("samples that are not of their type", std::to_string(broken_));
  if (astray > 0) {
    line("samples with numbers that do not go on from those before", std::to_string(astray));
  }
  if (left_out_ > 0) line("samples left out, of no station", std::to_string(left_out_));
  for (const std::string& problem : problems_) line("problem", problem);
  text += "\n## Scenes\n\n| scene | hash (XXH3 of its bundle) |\n|---|---|\n";
  for (const auto& [name, hash] : scenes_) {
    text += fmt::format("| {} | {} |\n", Cell(name), Cell(hash));
  }
  text +=
      "\n## Sessions\n\n| station | run | scene | tool | device | spring | pose rate | wrench rate "
      "| "
      "missing | largest force wanted, applied | limiter: calls "
      "|\n|---|---|---|---|---|---|---|---|---|---|---|\n";
  for (const Session& s : sessions_) {
    const auto find = [&](const std::string& topic) {
      const auto it = topics_.find(topic);
      return it == topics_.end() ? Topic{} : it->second;
    };
    const Topic poses = find(dds::PoseTopic(s.station, s.run)),
                wrenches = find(dds::WrenchTopic(s.station, s.run));
    std::string calls;
    for (const auto& [stage, count] : s.limiter_calls) {
      if (count > 0) calls += fmt::format("{}{} {}", calls.empty() ? "" : ", ", stage, count);
    }
    text += fmt::format(
        "| {} | `{}` | {} | {} | {} | {:g} N/m, {:g} N m/rad | {:.1f} Hz | {:.1f} Hz | {} | {:.3f} "
        "N, "
        "{:.3f} N | {} |\n",
        Cell(s.station), Hex16(s.run), Cell(s.scene), Cell(s.tool), Cell(s.device),
        s.stiffness_N_per_m, s.torsional_stiffness_Nm_per_rad, poses.rate_Hz(), wrenches.rate_Hz(),
        poses.sequence.missing() + wrenches.sequence.missing(), s.wanted_force_N, s.applied_force_N,
        s.limiter_periods == 0 ? "not recorded"
        : calls.empty()        ? "none"
                               : calls);
  }
  return text +
         "\nThe limiter's bounds are those of the device's data sheet "
         "(Palpate's page \"Devices\" has them), tightened where the station was told so; a "
         "recording "
         "holds what was wanted and applied, and how often each stage acted.\n";
}

}  // namespace palpate
