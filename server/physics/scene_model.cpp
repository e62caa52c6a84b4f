#include "server/physics/scene_model.h"

#include <algorithm>
#include <string>
#include <vector>

#include "common/error.h"
#include "common/math/default_rounding.h"
#include "common/math/pose_check.h"
#include "common/math/rotation.h"
#include "server/physics/limits.h"
#include "server/physics/step_state.h"

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

/// Returns the groups that are free bodies, as their numbers in Body::moved.
std::vector<std::uint32_t> FreeBodies(const Scene& scene) {
  std::vector<std::uint32_t> groups;
  for (std::size_t i = 0; i < scene.moved.size(); ++i) {
    if (scene.moved[i].free) groups.push_back(static_cast<std::uint32_t>(i + 1));
  }
  return groups;
}

std::size_t CountHands(const Scene& scene) {
  return scene.hands_meet ? scene.tools.size() : 1;
}

/// Makes the objects of a scene: what stands still, and those that move from `first` on, counted as
/// members of a step.
std::shared_ptr<SceneObjects> MakeObjects(const Scene& scene, std::size_t first) {
  const DefaultRounding rounding;
  std::vector<PlacedTree> placed;
  std::vector<CutSolid> solids;
  const bool for_balls =
      std::ranges::any_of(scene.tools, [](const Body& tool) { return tool.tree.leaves() == 1; });
  const std::vector<std::uint32_t> free = FreeBodies(scene);
  const std::size_t hands = CountHands(scene);
  for (const Body& object : scene.objects) {
    if (!IsPose(object.X_WB)) {
      throw Error(object.name + ": its pose must be finite, its quaternion of length 1");
    }
    for (const Material& m : object.materials) {
      const std::string fault = MaterialFault(m.stiffness, m.static_friction, m.dynamic_friction);
      if (!fault.empty()) throw Error(object.name + ": " + fault);
    }
    PlacedTree tree{&object.tree,     object.X_WB,
                    &object.mesh,     object.leaf_material,
                    object.materials, object.grid.has_value(),
                    for_balls,        static_cast<std::int32_t>(object.moved)};
    if (const auto at = std::ranges::find(free, object.moved); at != free.end()) {
      const std::size_t member = hands + static_cast<std::size_t>(at - free.begin());
      if (member < first) continue;
      tree.tool = static_cast<std::int32_t>(member);
      tree.is_body = true;
    }
    placed.push_back(tree);
    if (object.grid) {
      solids.push_back(SolidOf(object));
      solids.back().object = static_cast<std::uint32_t>(placed.size() - 1);
    }
  }
  for (std::size_t j = first; scene.hands_meet && j < scene.tools.size(); ++j) {
    const Body& tool = scene.tools[j];
    placed.push_back({.tree = &tool.tree,
                      .mesh = &tool.mesh,
                      .materials = tool.materials,
                      .for_balls = for_balls,
                      .frame = static_cast<std::int32_t>(scene.moved.size() + j - first + 1),
                      .tool = static_cast<std::int32_t>(j)});
  }
  // What there is nothing for to touch still needs an object: the body itself, far away.
  if (placed.empty() && !free.empty()) {
    const Body& object = scene.objects.back();
    placed.push_back(
        {.tree = &object.tree, .X_WB = {kAway, Quat::Identity()}, .mesh = &object.mesh});
  }
  const bool knows_all = first <= hands;
  return std::make_shared<SceneObjects>(placed, scene.features.contact, std::move(solids),
                                        knows_all ? scene.moved : std::vector<MovedGroup>{});
}

TriangleMesh Placed(TriangleMesh mesh, const Pose& X) {
  for (Vec3& vertex : mesh.vertices) vertex = X * vertex;
  return mesh;
}

/// Of a tree whose leaves nothing touches.
SphereTree Placed(SphereTree tree, const Pose& X) {
  for (std::size_t i = 0; i < tree.leaves(); ++i) {
    const Vec3 centre = X * Vec3(tree.leaf_x[i], tree.leaf_y[i], tree.leaf_z[i]);
    tree.leaf_x[i] = centre.x();
    tree.leaf_y[i] = centre.y();
    tree.leaf_z[i] = centre.z();
  }
  for (SpherePacket& packet : tree.packets) {
    for (int lane = 0; lane < kTreeArity; ++lane) {
      const Eigen::Vector3f centre =
          (X * Vec3(packet.x[lane], packet.y[lane], packet.z[lane])).cast<float>();
      packet.x[lane] = centre.x();
      packet.y[lane] = centre.y();
      packet.z[lane] = centre.z();
      packet.radius[lane] *= 1.0f + 1e-5f;
    }
  }
  return tree;
}

/// Makes the model of a free body: what it may touch is what stands still, and the bodies after it.
HapticModel MakeBodyModel(const Scene& scene, std::size_t body) {
  const std::uint32_t number = FreeBodies(scene)[body];
  const MovedGroup& group = scene.moved[number - 1];
  const FreeBody& free = *group.free;
  if (std::ranges::count(scene.objects, number, &Body::moved) != 1) {
    throw Error(group.name + ": a free body must be one object");
  }
  const Body& object = *std::ranges::find(scene.objects, number, &Body::moved);
  if (object.tree.leaves() == 1) {
    throw Error(object.name + ": a free body must be touched by its mesh; give it more leaves");
  }
  constexpr double kPeriod = 1e-3;
  StepParameters parameters{scene.tuning};
  parameters.stiffness = free.mass / (kPeriod * kPeriod);
  const double rho = RotationLengthOf(free);
  parameters.torsional_stiffness = rho * rho * parameters.stiffness;
  parameters.features = scene.features;
  parameters.max_rows = limits::body::kMaxRows;
  SphereTree tree = Placed(object.tree, object.X_WB);
  tree.centroid = free.centre;
  const TriangleMesh mesh = Placed(object.mesh, object.X_WB);
  return HapticModel(tree, MakeObjects(scene, CountHands(scene) + body + 1), parameters, &mesh,
                     std::nullopt, Effects(), Inertia{free, scene.gravity});
}

}  // namespace

std::shared_ptr<const SceneObjects> MakeObjects(const Scene& scene) {
  const DefaultRounding rounding;
  const std::shared_ptr<SceneObjects> objects = MakeObjects(scene, CountHands(scene));
  const std::size_t bodies = FreeBodies(scene).size();
  if (bodies == 0) return objects;
  if (CountHands(scene) + bodies > kMostMembers) {
    throw Error(scene.name + ": has " + std::to_string(bodies) +
                " free bodies; with its hands, at most " + std::to_string(kMostMembers) +
                " can move together; let some stand still");
  }
  FreeBodyModels models;
  for (std::size_t i = 0; i < bodies; ++i) {
    models.push_back(std::make_unique<const HapticModel>(MakeBodyModel(scene, i)));
  }
  objects->free_bodies = std::make_shared<const FreeBodyModels>(std::move(models));
  return objects;
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
  if (scene.hands_meet) {
    // What it touches are the hands after it.
    const std::shared_ptr<SceneObjects> own = MakeObjects(scene, next);
    own->free_bodies = objects->free_bodies;
    objects = own;
  }
  return HapticModel(tool.tree, std::move(objects), parameters, &tool.mesh,
                     tool.bur ? std::optional(CuttingOf(*tool.bur)) : std::nullopt,
                     Effects(scene.effects));
}

}  // namespace palpate
