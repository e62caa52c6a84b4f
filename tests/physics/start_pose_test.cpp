#include "server/physics/start_pose.h"

#include <gtest/gtest.h>

#include "scenes/shapes/shapes.h"
#include "server/physics/scene_model.h"
#include "tests/support/test_scenes.h"
#include "tests/support/test_trees.h"

namespace palpate {
namespace {

using test::MakeTree;
using test::Shell;

struct Setting {
  explicit Setting(double tool_radius)
      : tool(MakeTree(std::vector<test::Ball>{{Vec3::Zero(), tool_radius}})),
        object(MakeTree(Shell(2000, 0.05, 0.005))),
        model(tool, Objects(), {}),
        workspace(model) {}
  std::shared_ptr<const SceneObjects> Objects() {
    const PlacedTree placed{&object, {}};
    return std::make_shared<const SceneObjects>(std::span(&placed, 1));
  }
  SphereTree tool, object;
  HapticModel model;
  StepWorkspace workspace;
};

TEST(ResolveStart, LeavesAFreePoseAlone) {
  Setting setting(0.005);
  Pose X;
  X.p = Vec3(0.0, 0.0, 0.06);
  const StartPose start = ResolveStart(setting.model, X, setting.workspace);
  EXPECT_EQ(start.depth, 0.0);
  EXPECT_EQ(start.X_WG.p, X.p);
}

TEST(ResolveStart, BringsAToolOutToTheSurfaceAndSaysHowDeepItWas) {
  Setting setting(0.005);
  for (const double depth : {1e-3, 4e-3}) {
    Pose X;
    X.p = (0.055 - depth) * Vec3(0.48, 0.6, 0.64);
    const StartPose start = ResolveStart(setting.model, X, setting.workspace);
    EXPECT_NEAR(start.depth, depth, 0.3e-3) << depth;
    // A step can go on from there: no force but the spring's, nothing to push out of.
    StepState state;
    state.X_WG = start.X_WG;
    const StepReport report = HapticStep(setting.model, X, state, setting.workspace);
    EXPECT_LT(report.wrench.force.norm(), 1000.0 * depth * 1.3);
    EXPECT_EQ(report.faults & kFaultJammed, 0u);
  }
}

TEST(ResolveStart, BringsAToolOutOfAMeshWhereNoLeafTells) {
  Scene scene;
  scene.features.contact = ContactModel::kSurface;
  scene.tools.push_back(test::MakeMeshBody("tool", MakeBox({0.0006, 0.0006, 0.0006})));
  scene.objects.push_back(test::MakeMeshBody("egg", MakeEllipsoid({0.03, 0.02, 0.02}, 1280)));
  scene.objects.push_back(test::MakeMeshBody("block", MakeBox({0.04, 0.04, 0.04})));
  scene.objects[1].X_WB.p = Vec3(0.1, 0.0, 0.0);
  const HapticModel model = MakeModel(scene, scene.tools[0], MakeObjects(scene));
  StepWorkspace workspace(model);
  const auto start = [&](const Vec3& p) {
    return ResolveStart(model, Pose{p, Quat::Identity()}, workspace);
  };
  EXPECT_NEAR(start({0.118, 0.0, 0.0}).depth, 0.0023, 1e-4) << "2 mm below a face of the block";
  EXPECT_NEAR(start({0.0, 0.018, 0.0}).depth, 0.0023, 3e-4);
  EXPECT_EQ(start({0.028, 0.018, 0.0}).depth, 0.0) << "in the egg's box, beside the egg";
  EXPECT_EQ(start({0.14, 0.0, 0.0}).depth, 0.0);
}

TEST(ResolveStart, LooksForAWayOutAsFarAsMeshesReach) {
  Scene scene;
  scene.features.contact = ContactModel::kSurface;
  scene.tools.push_back(test::MakeMeshBody("tool", MakeBox({0.002, 0.002, 0.002})));
  Body plate{"plate", MakeBox({0.2, 0.2, 0.2}), {}, {}};
  plate.tree = TreeOverBalls(plate.mesh, {{Vec3::Zero(), 0.002}});
  scene.objects.push_back(plate);
  const HapticModel model = MakeModel(scene, scene.tools[0], MakeObjects(scene));
  StepWorkspace workspace(model);
  EXPECT_NEAR(ResolveStart(model, {}, workspace).depth, 0.101, 1e-4);
}

}  // namespace
}  // namespace palpate
