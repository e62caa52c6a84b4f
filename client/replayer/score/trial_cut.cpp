#include "client/replayer/score/trial_cut.h"

#include <chrono>
#include <map>
#include <utility>

#include "client/replayer/score/cut_sweep.h"
#include "common/dds/topics.h"
#include "common/dds/wire.h"
#include "common/error.h"
#include "common/recording/recording_reader.h"

namespace palpate {
namespace {

/// Time between two checks of a recording that is being made.
constexpr std::chrono::milliseconds kPause{100};

SolidsCut CutAgain(const std::string& file, const HandPath& path) {
  VerifyOptions options;
  options.whose = {path.station, path.run};
  for (SessionVerdict& session : Verify({file}, options).sessions) {
    if (session.station != path.station || session.run != path.run) continue;
    if (session.good()) return *std::move(session.cut);
    throw Error(file + ": what station '" + path.station + "' cut cannot be computed again: " +
                (session.ends.empty() ? "this version gives other forces than were recorded; score "
                                        "it with the version that recorded it"
                                      : session.ends));
  }
  throw Error(file + ": has no wrench of station '" + path.station + "'; record it anew");
}

}  // namespace

std::optional<SolidsCut> SweptIn(const std::string& file, const HandPath& path,
                                 const PlayedScene& played, StopSignal* stop) {
  CutSweep sweep(played, path.tool_name, path.station, path.run);
  RecordingReader reader({file});
  for (bool is_all = stop == nullptr;; reader.Grow()) {
    for (RecordedSample sample{}; reader.Next(sample);) sweep.Hear(sample);
    if (is_all || reader.complete()) {
      return reader.damaged() ? std::nullopt : sweep.Finish();
    }
    is_all = stop->WaitFor(kPause);
  }
}

SolidsCut CutIn(const std::string& file, const HandPath& path) {
  std::optional<SolidsCut> cut;
  try {
    cut = SweptIn(file, path, SceneIn(file, path.scene));
  } catch (const Error&) {  // for instance without its scene, which Verify may find elsewhere
  }
  return cut ? *std::move(cut) : CutAgain(file, path);
}

std::optional<BegunTrial> BegunIn(const std::string& file, const std::string& station,
                                  StopSignal& stop) {
  const std::string name = station.substr(0, station.find('/'));
  do {
    bool is_all = false;
    try {
      RecordingReader reader({file});
      // Servers repeat the states of sessions that have ended: only one with poses is of now.
      std::map<std::pair<std::string, std::uint64_t>, wire::SessionState> states;
      std::optional<HandPath> begun;
      for (RecordedSample sample{}; reader.Next(sample);) {
        wire::SessionState state{};
        if (sample.type == RecordedType::kHapticPose) {
          const auto key = dds::SessionOfTopic(*sample.topic);
          const auto of = key ? states.find(*key) : states.end();
          if (of == states.end() || (begun && begun->run == of->second.run)) continue;
          begun.emplace();
          begun->station = of->second.station;
          begun->run = of->second.run;
          begun->scene = of->second.scene;
          begun->tool_name = of->second.tool;
        } else if (sample.To(state) && (name.empty() || name == state.station)) {
          states[{state.station, state.run}] = state;
          if (state.phase == palpate_SESSION_ENDED && begun && begun->run == state.run) {
            begun.reset();
          }
        }
      }
      is_all = reader.complete();
      if (begun) return BegunTrial{*begun, SceneIn(file, begun->scene)};
    } catch (const Error&) {  // file or scene are not there yet
    }
    if (is_all) return std::nullopt;
  } while (!stop.WaitFor(kPause));
  return std::nullopt;
}

}  // namespace palpate
