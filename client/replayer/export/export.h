#pragma once

#include <string>
#include <vector>

#include "client/replayer/export/column_file.h"
#include "common/program/stop_signal.h"

namespace palpate {

struct ExportOptions {
  std::vector<std::string> files;  ///< of the recording
  std::string folder;              ///< to be made
  ColumnFormat format = ColumnFormat::kCsv;
};

/// Writes a recording as columns: a folder for each session, whose tables SessionColumns describes,
/// and methods.json and METHODS.md beside them (ExportFolder).  Progress goes to stderr.
/// Throws Error where the recording cannot be read, the folder is there already, or it was stopped.
void Export(const ExportOptions& options, StopSignal& stop);

}  // namespace palpate
