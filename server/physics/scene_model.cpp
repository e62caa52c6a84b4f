#include "server/physics/scene_model.h"

#include <algorithm>
#include <string>
#include <vector>

#include "common/error.h"
#include "common/math/default_rounding.h"
#include "common/math/pose_check.h"
#include "common/math/rotation.h"
#include "server/physics/limits.h"

namespace palpate {

static_assert(StepTuning{} == StepTuning{limits::mesh::kSeparation, limits::kMaxTranslation,
                                         limits::kMaxSubsteps, limits::mesh::kIterates,
                                         limits::mesh::kMaxQueries, limits::friction::kStillCycles},
              "a scene that leaves its tuning out is stepped as the physics' pages say");

namespace {

CutSolid SolidOf(const Body& body) {
  CutSolid solid{MakeSolidGrid(body), body.X_WB, {}, 0};
  std::ranges::copy(body.materials, solid.materials.begin());  // at most eight (MakeSolidGrid)
  return solid;
}

/// The bur's axis is z in its own frame and y in the tool's; both point away from
/// the tip.  A quarter turn about x converts them, written without a sine because
/// libm's differs between processors.
Cutting CuttingOf(const BurProfile& profile) {
  constexpr double kHalf = 0.70710678118654752;
  const Quat z_to_y(kHalf, -kHalf, 0.0, 0.0);
  Cutting cutting{Bur(profile.curve, profile.rounding), {Vec3(0.0, profile.rounding, 0.0), z_to_y}};
  if (const auto& edge = profile.edge) {
    cutting.X_TB = {edge->at, RotationBetween(Vec3::UnitZ(), edge->along)};
    cutting.sense = edge->sense;
  }
  cutting.spin = profile.spin;
  cutting.dead_tip = profile.dead_tip;
  cutting.cutting = profile.cutting;
  return cutting;
}

/// Makes the objects of a scene, and the tools from `first_tool` on.
std::shared_ptr<const SceneObjects> MakeObjects(const Scene& scene, std::size_t first_tool) {
  const DefaultRounding rounding;
  std::vector<PlacedTree> placed;
  std::vector<CutSolid> solids;
  const bool for_balls =
      std::ranges::any_of(scene.tools, [](const Body& tool) { return tool.tree.leaves() == 1; });
  for (const Body& object : scene.objects) {
    if (!IsPose(object.X_WB)) {
      throw Error(object.name + ": its pose must be finite, its quaternion of length 1");
    }
    for (const Material& m : object.materials) {
      const std::string fault = MaterialFault(m.stiffness, m.static_friction, m.dynamic_friction);
      if (!fault.empty()) throw Error(object.name + ": " + fault);
    }
    placed.push_back({&object.tree, object.X_WB, &object.mesh, object.leaf_material,
                      object.materials, object.grid.has_value(), for_balls,
                      static_cast<std::int32_t>(object.moved)});
    if (object.grid) {
      solids.push_back(SolidOf(object));
      solids.back().object = static_cast<std::uint32_t>(placed.size() - 1);
    }
  }
  for (std::size_t j = first_tool; j < scene.tools.size(); ++j) {
    const Body& tool = scene.tools[j];
    placed.push_back({.tree = &tool.tree,
                      .mesh = &tool.mesh,
                      .materials = tool.materials,
                      .for_balls = for_balls,
                      .frame = static_cast<std::int32_t>(j - first_tool + 1),
                      .tool = static_cast<std::int32_t>(j)});
  }
  return std::make_shared<const SceneObjects>(placed, scene.features.contact, std::move(solids),
                                              scene.moved);
}

}  // namespace

std::shared_ptr<const SceneObjects> MakeObjects(const Scene& scene) {
  return MakeObjects(scene, scene.tools.size());
}

HapticModel MakeModel(const Scene& scene, const Body& tool,
                      std::shared_ptr<const SceneObjects> objects) {
  const DefaultRounding rounding;
  const std::string fault =
      SpringFault(scene.coupling.stiffness, scene.coupling.torsional_stiffness);
  if (!fault.empty()) throw Error("coupling: " + fault);
  StepParameters parameters{scene.tuning};
  parameters.stiffness = scene.coupling.stiffness;
  parameters.torsional_stiffness = scene.coupling.torsional_stiffness;
  parameters.features = scene.features;
  const auto number = std::ranges::find(scene.tools, tool.name, &Body::name) - scene.tools.begin();
  const std::size_t next = static_cast<std::size_t>(number) + 1;
  if (scene.hands_meet && next < scene.tools.size()) objects = MakeObjects(scene, next);
  return HapticModel(tool.tree, std::move(objects), parameters, &tool.mesh,
                     tool.bur ? std::optional(CuttingOf(*tool.bur)) : std::nullopt,
                     Effects(scene.effects));
}

}  // namespace palpate
