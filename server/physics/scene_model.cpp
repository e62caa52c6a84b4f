#include "server/physics/scene_model.h"

#include <vector>

namespace palpate {

std::shared_ptr<const SceneObjects> MakeObjects(const Scene& scene) {
  std::vector<PlacedTree> placed;
  for (const Body& object : scene.objects) {
    placed.push_back(
        {&object.tree, object.X_WB, &object.mesh, object.leaf_material, object.materials});
  }
  return HapticModel::MakeObjects(placed, scene.features.contact);
}

HapticModel MakeModel(const Scene& scene, const Body& tool,
                      std::shared_ptr<const SceneObjects> objects) {
  StepParameters parameters;
  parameters.stiffness = scene.coupling.stiffness;
  parameters.torsional_stiffness = scene.coupling.torsional_stiffness;
  parameters.features = scene.features;
  return HapticModel(tool.tree, std::move(objects), parameters, &tool.mesh);
}

}  // namespace palpate
