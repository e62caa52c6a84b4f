#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "client/load/load_figures.h"
#include "client/load/options.h"
#include "client/station/served_tools.h"
#include "common/json/pose_script.h"
#include "common/program/stop_signal.h"

namespace palpate {

/// How much, of the options' kind.
struct LoadSize {
  std::size_t stations = 0;
  std::size_t viewers = 0;
  double seconds = 0.0;
};

/// What runs have in common.
struct LoadSetting {
  const LoadRunOptions& options;
  std::vector<OfferedTool> tools;
  std::vector<PoseScript> scripts;  ///< of each tool
  std::function<void(const std::string&)> progress;
};

/// Puts the load on, measures it, and takes it away again.  Nothing where `stop` came before the
/// measurement began; where it comes later, what there is until then.  Throws Error.
/// @param realtime  where given, what the stations' loops were granted is put there.
std::optional<LoadFigures> RunOnce(const LoadSetting& setting, const LoadSize& size,
                                   StopSignal& stop, std::string* realtime = nullptr);

}  // namespace palpate
