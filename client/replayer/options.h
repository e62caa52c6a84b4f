#pragma once

#include <optional>
#include <string>
#include <variant>

#include "client/replayer/commands/commands.h"

namespace palpate {

struct ReplayOptions {
  std::variant<PlayCommand, VerifyCommand, GuideCommand, ScoreCommand, VerifyExamCommand,
               RehearseCommand, CriteriaCommand, ExportCommand, StepsCommand>
      command;
  std::string log_level = "info";
};

/// Reads the command line.  For --help and --version prints them and returns nothing.
/// Throws UsageError.
std::optional<ReplayOptions> ParseReplayOptions(int argc, const char* const* argv);

}  // namespace palpate
