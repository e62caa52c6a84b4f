#pragma once

#include "scenes/files/mesh_scene.h"

namespace CLI {
class App;
}

namespace palpate {

/// Adds --unit and --ball, which every program has that takes a mesh in place of a scene.
void AddMeshOptions(CLI::App& app, MeshSceneOptions& options);

}  // namespace palpate
