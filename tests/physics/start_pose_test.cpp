#include "server/physics/start_pose.h"

#include <gtest/gtest.h>

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
    return HapticModel::MakeObjects(std::span(&placed, 1));
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
    // It is where a step may go on: no force but the spring's, nothing to push out of.
    StepState state;
    state.X_WG = start.X_WG;
    const StepReport report = HapticStep(setting.model, X, state, setting.workspace);
    EXPECT_LT(report.wrench.force.norm(), 1000.0 * depth * 1.3);
    EXPECT_EQ(report.faults & kFaultJammed, 0u);
  }
}

}  // namespace
}  // namespace palpate
