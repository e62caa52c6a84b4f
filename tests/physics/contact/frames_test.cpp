#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "scenes/shapes/shapes.h"
#include "server/physics/haptic_model.h"
#include "server/physics/haptic_step.h"
#include "tests/support/mesh_oracle.h"
#include "tests/support/test_scenes.h"

namespace palpate {
namespace {

using test::MakeMeshBody;
using test::MeshOracle;

/// A box over a floor, between two walls that lean towards it: every contact of it is with several
/// bodies at once.
Scene BoxInAGroove() {
  Scene scene;
  scene.tools.push_back(MakeMeshBody("box", MakeBox(Vec3(0.013, 0.010, 0.011))));
  const auto wall = [](double side) {
    return Pose{Vec3(0.02 * side, 0.0, 0.0), Quat(Eigen::AngleAxisd(0.2 * side, Vec3::UnitY()))};
  };
  scene.objects.push_back(MakeMeshBody("floor", MakeBox(Vec3(0.06, 0.06, 0.01)),
                                       Pose{Vec3(0.0, 0.0, -0.015), Quat::Identity()}));
  scene.objects.push_back(MakeMeshBody("left", MakeBox(Vec3(0.01, 0.05, 0.03)), wall(-1.0)));
  scene.objects.push_back(MakeMeshBody("right", MakeBox(Vec3(0.01, 0.05, 0.03)), wall(1.0)));
  scene.features.contact = ContactModel::kSurface;
  return scene;
}

/// The model of a scene whose objects have these frames.
HapticModel ModelOf(const Scene& scene, std::array<int, 3> frame, FrictionModel friction) {
  std::vector<PlacedTree> placed;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    const Body& object = scene.objects[i];
    placed.push_back({.tree = &object.tree,
                      .X_WB = object.X_WB,
                      .mesh = &object.mesh,
                      .leaf_material = object.leaf_material,
                      .materials = object.materials,
                      .frame = frame[i]});
  }
  StepParameters parameters;
  parameters.features = scene.features;
  parameters.features.friction = friction;
  const Body& tool = scene.tools.front();
  return HapticModel(tool.tree,
                     std::make_shared<const SceneObjects>(placed, ContactModel::kSurface),
                     parameters, &tool.mesh);
}

/// A hand that swings between the walls and into the floor, and turns.
Pose HandAt(int i) {
  const double t = 1e-3 * i;
  const Vec3 turn(0.3 * std::sin(7.0 * t), 0.2 * std::sin(5.0 * t), 0.5 * std::sin(3.0 * t));
  return {Vec3(0.012 * std::sin(9.0 * t), 0.01 * std::sin(4.0 * t), 0.004 * std::cos(6.0 * t)),
          RotationExp(turn)};
}

// Bodies that stand still to each other are one frame; were each a frame of its own, with a front
// of its own, nothing could be felt of it.
TEST(Frames, GiveTheForcesOfOneFrameIfTheyStandStill) {
  const Scene scene = BoxInAGroove();
  for (const FrictionModel friction : {FrictionModel::kOff, FrictionModel::kCoulomb}) {
    const HapticModel one = ModelOf(scene, {0, 0, 0}, friction);
    const HapticModel three = ModelOf(scene, {0, 1, 2}, friction);
    StepWorkspace workspace_of_one(one), workspace_of_three(three);
    StepState state_of_one(one), state_of_three(three);
    ASSERT_EQ(state_of_three.fronts.size(), 3u);
    MeshOracle oracle(scene);
    int held = 0, by_several = 0;
    for (int i = 0; i < 2500; ++i) {
      const StepReport a = HapticStep(one, HandAt(i), state_of_one, workspace_of_one);
      const StepReport b = HapticStep(three, HandAt(i), state_of_three, workspace_of_three);
      ASSERT_FALSE(oracle.Meet(state_of_three.X_WG)) << i;
      if (((a.faults | b.faults) & kFaultTargetFar) != 0) continue;
      // As far apart as two answers may be that both keep delta: 1 um, which is 1 mN.
      ASSERT_LT((a.wrench.force - b.wrench.force).norm(), 2e-3) << i;
      held += b.contacts > 0 ? 1 : 0;
      for (int k = 1; k < b.contacts; ++k) {
        by_several += b.active[std::size_t(k)].id.body != b.active[0].id.body ? 1 : 0;
      }
    }
    EXPECT_GT(held, 500);
    EXPECT_GT(by_several, 50);
  }
}

}  // namespace
}  // namespace palpate
