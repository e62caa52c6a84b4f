#pragma once

#include <string>
#include <vector>

#include "client/replayer/export/column_file.h"
#include "common/program/stop_signal.h"

namespace palpate {

struct ExportOptions {
  std::vector<std::string> files;  ///< of the recording
  std::string folder;              ///< created by the export
  ColumnFormat format = ColumnFormat::kCsv;
};

/// Writes a recording as columns: one folder per session, whose tables SessionColumns describes,
/// with methods.json and METHODS.md beside them (ExportFolder).  Progress goes to stderr.
/// Throws Error if the recording cannot be read, the folder already exists, or the export
/// was stopped.
void Export(const ExportOptions& options, StopSignal& stop);

}  // namespace palpate
