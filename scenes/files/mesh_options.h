#pragma once

#include "scenes/files/mesh_scene.h"

namespace palpate {

class CommandLine;

/// Adds --unit and --ball, the options of every program that takes a mesh in place of a scene.
void AddMeshOptions(const CommandLine& app, MeshSceneOptions& options);

}  // namespace palpate
