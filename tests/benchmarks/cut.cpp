// palpate-bench cut: a bur's volume, force, work and time.
#include <memory>

#include "tests/benchmarks/commands.h"
#include "tests/benchmarks/cut_scene.h"

namespace palpate::bench {

void AddCut(const CommandLine& app) {
  auto options = std::make_shared<CutSceneOptions>();
  const CommandLine command = app.AddCommand(
      "cut", "volume, force and work of a bur against the law, and the time of a step");
  command.Footer("Example: palpate-bench cut --scene caries --json cut.json");
  Add(command, "--scene", options->scene, "scene with a bur, from the catalogue or a file")
      .Required();
  Add(command, "--poses", options->poses,
      "haptic poses (CSV: x,y,z,qw,qx,qy,qz, one row per millisecond); default: the scene's "
      "script, else a plunge and a groove");
  Add(command, "--surface", options->surface, "write the remaining solids to FILE.stl, in metres");
  Add(command, "--burs", options->burs,
      "cut the scene's block with each of these burs instead: ISO 6360 numbers such as "
      "001/014,237/014");
  AddRepeats(command, options->repeats);
  AddJson(command, options->json);
  command.Run([options] { RunCutScene(*options); });
}

}  // namespace palpate::bench
