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

/// The size of a load, made of the stations and viewers that the options describe.
struct LoadSize {
  std::size_t stations = 0;
  std::size_t viewers = 0;
  double seconds = 0.0;
};

/// The settings that all runs share.
struct LoadSetting {
  const LoadRunOptions& options;
  std::vector<OfferedTool> tools;
  std::vector<PoseScript> scripts;  ///< one per tool
  std::function<void(const std::string&)> progress;
};

/// Applies the load, measures it, and removes it again.  Returns nothing if `stop` came before the
/// measurement began; if it comes later, returns the figures up to then.  Throws Error.
std::optional<LoadFigures> RunOnce(const LoadSetting& setting, const LoadSize& size,
                                   StopSignal& stop);

}  // namespace palpate
