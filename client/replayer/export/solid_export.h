#pragma once

#include <limits>
#include <string>
#include <vector>

#include "common/program/stop_signal.h"

namespace palpate {

struct SolidExportOptions {
  std::vector<std::string> files;  ///< of the recording
  std::string folder;              ///< created by the export
  /// Time from the first sample; default: the end.
  double at_s = std::numeric_limits<double>::infinity();
  std::string models_dir = {};  ///< as in LoadOptions
};

/// Writes what the burs of a recording left of each solid, as OBJECT.stl and OBJECT.ply, in mm in
/// the solid's frame, the latter with the colours of its materials.  Also writes SCENE.palpate, a
/// scene with those solids, for any program.  If a server ran several times, each run has a folder.
/// The physics recomputes the cuts (Verify).  The folder is written as by Export.
/// Throws Error if wrenches differ from the recorded ones, nothing could be cut, or it was stopped.
void ExportSolids(const SolidExportOptions& options, StopSignal& stop);

}  // namespace palpate
