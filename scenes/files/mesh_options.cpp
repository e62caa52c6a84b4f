#include "scenes/files/mesh_options.h"

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "scenes/files/scene_file.h"

namespace palpate {

void AddMeshOptions(CLI::App& app, MeshSceneOptions& options) {
  app.add_option(
         "--unit", options.unit,
         "for a mesh: the unit of the numbers in its file; default: m or mm, guessed from the size")
      ->check(CLI::IsMember(std::vector<std::string>(kUnits.begin(), kUnits.end())));
  app.add_option_function<double>(
         "--ball", [&options](double mm) { options.ball_m = 1e-3 * mm; },
         "for a mesh: radius in mm of the ball that touches it; default: 1/20 of its longest side")
      ->check(CLI::Range(1e-3, 1e3));
}

}  // namespace palpate
