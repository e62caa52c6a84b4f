#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/dds/participant.h"
#include "common/program/command_line.h"
#include "common/recording/recording_writer.h"

namespace palpate {

struct RecorderOptions : ServerOptions {
  // Files of `info`; empty: make a recording.
  std::vector<std::string> info_files;
  std::string json;  ///< output of `info`: file or "-"; empty: none

  RecordingOptions recording;
  bool loop = true;
  std::vector<std::string> stations;  ///< record only these; empty: all
  std::string scene;  ///< say that it records once it has this scene; empty: at once
  std::optional<double> seconds;
  dds::Transport transport = dds::Transport::kAuto;
};

/// Reads the command line.  For --help and --version prints them and returns nothing.
/// Throws UsageError.
std::optional<RecorderOptions> ParseRecorderOptions(int argc, const char* const* argv);

}  // namespace palpate
