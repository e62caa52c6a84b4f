#pragma once

#include <memory>
#include <string>
#include <vector>

#include "scenes/shapes/shapes.h"
#include "server/physics/scene_model.h"
#include "server/session/session.h"
#include "tests/support/test_scenes.h"
#include "tests/support/test_trees.h"

namespace palpate::test {

inline constexpr double kBurRadius = 0.7e-3;

/// A block with its upper face at z = 0, and ball burs on pins that touch nothing but the block.
inline Scene BlockScene(const std::vector<std::string>& burs = {"bur", "other"}) {
  Scene scene;
  scene.name = "block";
  TriangleMesh mesh = MakeBox(Vec3(6e-3, 3e-3, 2e-3));
  for (Vec3& v : mesh.vertices) v.z() -= 1e-3;
  Body block = MakeBody("block", mesh, 16);
  block.grid = BodyGrid{.spacing = 100e-6, .regions = {}};
  block.materials = {Material{.cutting_pressure = 0.1e6, .cutting_viscosity = 0.01e9}};
  scene.objects = {block};
  for (const std::string& name : burs) {
    Body& bur = scene.tools.emplace_back();
    bur.name = name;
    const Ball ball{Vec3(0, kBurRadius, 0), 0.5 * kBurRadius};
    bur.tree = MakeTree({&ball, 1});
    bur.bur = BurProfile{{{0.0, 0.0}}, kBurRadius};
  }
  return scene;
}

inline std::vector<std::shared_ptr<const ServedTool>> ToolsOf(const Scene& scene) {
  const auto objects = MakeObjects(scene);
  std::vector<std::shared_ptr<const ServedTool>> tools;
  for (const Body& tool : scene.tools) {
    tools.push_back(std::make_shared<const ServedTool>(
        ServedTool{scene.name, tool.name, MakeModel(scene, tool, objects)}));
  }
  return tools;
}

/// Made once per process: the tools do not change, and making them takes longer than most tests.
inline std::vector<std::shared_ptr<const ServedTool>> BlockTools() {
  static const auto tools = ToolsOf(BlockScene());
  return tools;
}

}  // namespace palpate::test
