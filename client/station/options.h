#pragma once

#include <limits>
#include <optional>
#include <string>

#include "client/station/session_link.h"
#include "devices/device_factory.h"

namespace palpate {

struct StationOptions {
  LinkOptions link;
  DeviceOptions device;              ///< as far as set on the command line
  std::string workspace;             ///< file; empty: the scene's frame is the device's
  std::optional<double> scale;       ///< overrides the file's
  std::optional<int> clutch_button;  ///< overrides the file's
  std::string script;                ///< file; empty: the scene's own
  bool enable_forces = false;
  double max_force_N = std::numeric_limits<double>::infinity();
  bool local_model = true;
  bool accept_guide = false;
  double guide_force_N = 0.5;
  std::optional<double> seconds;
  std::optional<bool> table;  ///< empty: a table if stdout is a terminal
  std::string json;           ///< file or "-"; empty: none
  std::string trace;          ///< file; empty: none
  std::string log_level = "info";
};

/// Reads the command line.  For --help and --version prints them and returns nothing.
/// Throws UsageError.
std::optional<StationOptions> ParseStationOptions(int argc, const char* const* argv);

}  // namespace palpate
