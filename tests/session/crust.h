#pragma once

#include <memory>
#include <vector>

#include "scenes/scene_remains.h"
#include "server/physics/scene_model.h"
#include "server/session/session.h"
#include "tests/support/test_trees.h"

namespace palpate::test {

/// A floor of balls that a joule's hundredth scrapes off, felt with two ball tools.  Leaf i stands
/// for triangle i, and leaf 0 for 300 more.
inline Scene Crust() {
  Scene scene;
  scene.name = "crust";
  scene.features.contact = ContactModel::kSpheres;
  scene.features.removal = true;
  Body floor;
  floor.name = "floor";
  floor.tree = MakeTree(Floor(0.02, 0.002, 0.002));
  floor.materials = {Material{.hardness = 2e-3}};
  const auto leaves = static_cast<std::uint32_t>(floor.tree.leaves());
  floor.mesh.triangles.resize(leaves + 300);
  floor.tree.leaf_triangle_begin = {0};
  for (std::uint32_t leaf = 0; leaf < leaves; ++leaf) {
    floor.tree.leaf_triangle.push_back(leaf);
    for (std::uint32_t i = 0; leaf == 0 && i < 300; ++i) {
      floor.tree.leaf_triangle.push_back(leaves + i);
    }
    floor.tree.leaf_triangle_begin.push_back(
        static_cast<std::uint32_t>(floor.tree.leaf_triangle.size()));
  }
  scene.objects = {floor};
  for (const char* name : {"left", "right"}) {
    Body tool;
    tool.name = name;
    const Ball ball{Vec3::Zero(), 0.003};
    tool.tree = MakeTree({&ball, 1});
    scene.tools.push_back(tool);
  }
  return scene;
}

inline std::vector<std::shared_ptr<const ServedTool>> ToolsOf(const Scene& scene,
                                                              bool whole_at_start = false) {
  const auto whole = std::make_shared<const SceneRemains>(scene);
  const auto objects = MakeObjects(scene);
  std::vector<std::shared_ptr<const ServedTool>> tools;
  for (const Body& tool : scene.tools) {
    tools.push_back(std::make_shared<const ServedTool>(
        ServedTool{scene.name, tool.name, MakeModel(scene, tool, objects), whole, whole_at_start}));
  }
  return tools;
}

}  // namespace palpate::test
