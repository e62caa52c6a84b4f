#include "client/replayer/score/trial_cut.h"

#include <chrono>

#include "client/replayer/score/cut_sweep.h"
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

std::optional<HandPath> BegunIn(const std::string& file, const std::string& station,
                                StopSignal& stop) {
  const std::string name = station.substr(0, station.find('/'));
  do {
    try {
      RecordingReader reader({file});
      HandPath begun;
      bool has_scene = false;
      for (RecordedSample sample{}; reader.Next(sample);) {
        has_scene = has_scene || sample.type == RecordedType::kSceneBundle;
        wire::SessionState state{};
        if (!sample.To(state) || state.phase == palpate_SESSION_REFUSED) continue;
        if (!name.empty() && name != state.station) continue;
        begun.station = state.station;
        begun.run = state.run;
        begun.scene = state.scene;
        begun.tool_name = state.tool;
      }
      if (has_scene && !begun.station.empty()) return begun;
      if (reader.complete()) return std::nullopt;
    } catch (const Error&) {  // the file does not exist yet
    }
  } while (!stop.WaitFor(kPause));
  return std::nullopt;
}

}  // namespace palpate
