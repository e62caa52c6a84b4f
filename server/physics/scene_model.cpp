#include "server/physics/scene_model.h"

#include <vector>

#include "common/error.h"
#include "common/math/pose_check.h"
#include "server/physics/limits.h"

namespace palpate {

static_assert(StepTuning{} == StepTuning{limits::mesh::kSeparation, limits::kMaxTranslation,
                                         limits::kMaxSubsteps, limits::mesh::kIterates,
                                         limits::mesh::kMaxLooks, limits::friction::kStillCycles},
              "a scene that leaves its tuning out is stepped as the physics' pages say");

std::shared_ptr<const SceneObjects> MakeObjects(const Scene& scene) {
  std::vector<PlacedTree> placed;
  for (const Body& object : scene.objects) {
    if (!IsPose(object.X_WB)) {
      throw Error(object.name + ": its pose must be finite, its quaternion of length 1");
    }
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
  const StepTuning& tuning = scene.tuning;
  if (const std::string fault = TuningFault(tuning); !fault.empty()) throw Error("step: " + fault);
  parameters.separation = tuning.separation;
  parameters.max_translation = tuning.widest_step;
  parameters.max_substeps = tuning.sub_steps;
  parameters.iterates = tuning.iterates;
  parameters.looks = tuning.looks;
  parameters.still_cycles = tuning.still_cycles;
  parameters.features = scene.features;
  return HapticModel(tool.tree, std::move(objects), parameters, &tool.mesh);
}

}  // namespace palpate
