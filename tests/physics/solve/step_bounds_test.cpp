#include <gtest/gtest.h>

#include "scenes/shapes/shapes.h"
#include "server/physics/limits.h"
#include "server/physics/scene_model.h"
#include "server/physics/solve/stages.h"
#include "tests/support/step_bench.h"
#include "tests/support/test_scenes.h"

namespace palpate {
namespace {

using test::Ball;
using test::Bench;

const std::vector<Ball> kObject{{Vec3(0.0, 0.0, -1.0), 0.5}};
const std::vector<Ball> kStick{{Vec3(-0.05, 0.0, 0.0), 0.005}, {Vec3(0.05, 0.0, 0.0), 0.005}};

TEST(StepBounds, HoldTheLinearisationErrorBelowItsLimit) {
  const Bench bench(kStick, kObject);
  const StepParameters& parameters = bench.model().parameters();
  const double phi = parameters.max_rotation;
  EXPECT_NEAR(0.5 * phi * phi * bench.model().tool().max_lever, parameters.max_truncation, 1e-15);
}

TEST(StepBounds, BendAnArcBetweenMeshesByHalfOfWhatKeepsThemApart) {
  const Scene scene = test::MeshScene(MakeBox(Vec3::Constant(0.02)), MakeBox(Vec3::Constant(0.05)));
  const HapticModel model = MakeModel(scene, scene.tools.front(), MakeObjects(scene));
  const double reach = std::sqrt(3.0) * 0.01;  // of a corner from the centre
  const double arc = reach * (1.0 - std::cos(0.5 * model.parameters().max_rotation));
  EXPECT_NEAR(arc, 0.5 * limits::mesh::Margins{}.free, 1e-9);
}

TEST(FractionWithin, IsWhatBothBoundsAllow) {
  const StepBounds bounds{1e-3, 1e-2};
  EXPECT_EQ(FractionWithin(bounds, Vec3(0.0, 1e-3, 0.0), Vec3(0.0, 0.0, 1e-2)), 1.0);
  EXPECT_DOUBLE_EQ(FractionWithin(bounds, Vec3(4e-3, 0.0, 0.0), Vec3(0.0, 0.0, 2e-2)), 0.25);
  EXPECT_DOUBLE_EQ(FractionWithin(bounds, Vec3(2e-3, 0.0, 0.0), Vec3(0.0, 0.0, 5e-2)), 0.2);
}

}  // namespace
}  // namespace palpate
