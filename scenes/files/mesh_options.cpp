#include "scenes/files/mesh_options.h"

#include "common/program/command_line.h"
#include "scenes/files/scene_file.h"

namespace palpate {

void AddMeshOptions(const CommandLine& app, MeshSceneOptions& options) {
  app.Add("--unit", options.unit,
          "for a mesh: unit of the lengths in its file; default: m or mm, guessed from its size")
      .OneOf({kUnits.begin(), kUnits.end()});
  app.AddNumber(
         "--ball", [&options](double mm) { options.ball_m = 1e-3 * mm; },
         "for a mesh: radius in mm of the ball that touches it; default: 1/20 of the mesh's "
         "longest "
         "side")
      .Range(1e-3, 1e3);
}

}  // namespace palpate
