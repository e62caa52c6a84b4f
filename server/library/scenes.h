#pragma once

/// @file
/// All of palpate::scenes: what the server reads, for your own programs.
///
/// @code
/// const Scene scene = LoadScene("bunny-bunny");  // or a file: .json, .palpate, .stl, ...
/// const HapticModel model = MakeModel(scene, scene.tools[0], MakeObjects(scene));
/// const PoseScript hand = PoseScript::Load(ScriptFileBeside("bunny-bunny"));
/// Proxy proxy(model, hand.At(0.0));
/// const StepReport report = proxy.Step(hand.At(0.001));  // the bits of the server
/// SaveScene(scene, "mine.palpate");                      // also of your own; the server reads it
/// @endcode
///
/// palpate-import reads the meshes; catalogue and models are found beside it: in the folder that
/// $PALPATE_PROGRAMS names, or on the PATH (Debian's package palpate-common).
#include "common/json/pose_script.h"  // IWYU pragma: export
#include "scenes/catalogue.h"         // IWYU pragma: export
#include "scenes/progress_line.h"     // IWYU pragma: export
#include "server/library/physics.h"   // IWYU pragma: export

namespace palpate {

/// For LoadOptions::leaves: sphere trees that follow their meshes to within so many micrometres.
/// Throws Error unless they are from 0.1 to 1,000,000.
inline LeafTolerance HeightTolerance(double um) {
  if (!(um >= kLeastTolerance_um && um <= kMostTolerance_um)) {
    throw Error("tolerance_um: must be from 0.1 to 1000000");
  }
  return {.most = 1e-6 * um};
}

}  // namespace palpate
