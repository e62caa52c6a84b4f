#pragma once

#include <optional>
#include <string>

#include "client/station/session_link.h"

namespace palpate {

struct StationOptions {
  LinkOptions link;
  std::string script;  ///< file; empty: the scene's own
  bool loop = false;
  bool enable_forces = false;
  bool accept_guide = false;
  double guide_force_N = 0.5;
  std::optional<double> seconds;
  std::optional<bool> table;  ///< empty: as stdout is a terminal or not
  std::string json;           ///< file or "-"; empty: none
  std::string trace;          ///< file; empty: none
  std::string log_level = "info";
};

/// Reads the command line.  For --help and --version prints them and returns nothing.
/// Throws UsageError.
std::optional<StationOptions> ParseOptions(int argc, const char* const* argv);

}  // namespace palpate
