#pragma once

#include <limits>
#include <string>
#include <vector>

#include "common/program/stop_signal.h"

namespace palpate {

struct SolidExportOptions {
  std::vector<std::string> files;                         ///< of the recording
  std::string folder;                                     ///< to be made
  double at_s = std::numeric_limits<double>::infinity();  ///< from its first sample; else its end
  std::string models_dir = {};                            ///< as LoadOptions
};

/// Writes what the burs of a recording left: of each solid OBJECT.stl and OBJECT.ply, in mm in its
/// own frame, with the colours of its materials in the latter; and SCENE.palpate, a scene whose
/// solids are those, for any program.  Where a server ran several times, a folder for each run.
/// The physics computes it again (Verify).  The folder grows as that of Export.
/// Throws Error where wrenches are not what was recorded, nothing could be cut, or it was stopped.
void ExportSolids(const SolidExportOptions& options, StopSignal& stop);

}  // namespace palpate
