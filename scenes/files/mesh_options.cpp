#include "scenes/files/mesh_options.h"

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "scenes/files/scene_file.h"

namespace palpate {

void AddMeshOptions(CLI::App& app, MeshSceneOptions& options) {
  app.add_option(
         "--unit", options.unit,
         "of a mesh: what a number in its file means; default: m or mm, guessed by the size")
      ->check(CLI::IsMember(std::vector<std::string>(kUnits.begin(), kUnits.end())));
  app.add_option_function<double>(
         "--ball", [&options](double mm) { options.ball_m = 1e-3 * mm; },
         "of a mesh: radius in mm of the ball that feels it; default: a twentieth of its longest "
         "side")
      ->check(CLI::Range(1e-3, 1e3));
}

}  // namespace palpate
