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

TEST(StepBounds, AreTheLeastWhereTheHandRests) {
  const Bench bench(kStick, kObject);
  const StepParameters& parameters = bench.model().parameters();
  const StepBounds bounds = FirstBounds(bench.model(), Target{});
  EXPECT_DOUBLE_EQ(bounds.translation, 20e-6);
  EXPECT_DOUBLE_EQ(bounds.rotation, limits::kLeastBounds * parameters.max_rotation);
}

TEST(StepBounds, FollowTheHandUpToTheWidest) {
  const Bench bench(kStick, kObject);
  const StepParameters& parameters = bench.model().parameters();
  const double rho = bench.model().rotation_length();
  const Target slow{Vec3(0.0, 30e-6, 40e-6), Vec3(2e-5, 0.0, 0.0)};
  const StepBounds bounds = FirstBounds(bench.model(), slow);
  EXPECT_NEAR(bounds.translation, 20e-6 + 2.0 * (50e-6 + 0.5 * rho * 2e-5), 1e-12);
  EXPECT_NEAR(bounds.rotation, 0.04 * parameters.max_rotation + 2.0 * (2e-5 + 0.5 * 50e-6 / rho),
              1e-12);
  const StepBounds fast = FirstBounds(bench.model(), {Vec3(1.0, 0.0, 0.0), Vec3::UnitX()});
  EXPECT_EQ(fast.translation, parameters.widest_step);
  EXPECT_EQ(fast.rotation, parameters.max_rotation);
}

TEST(StepBounds, AddNothingAcrossBetweenMeshes) {
  const Scene scene = test::MeshScene(MakeBox(Vec3::Constant(0.02)), MakeBox(Vec3::Constant(0.05)));
  const HapticModel model = MakeModel(scene, scene.tools.front(), MakeObjects(scene));
  const Target slow{Vec3(0.0, 30e-6, 40e-6), Vec3(2e-5, 0.0, 0.0)};
  EXPECT_NEAR(FirstBounds(model, slow).translation, 20e-6 + 2.0 * 50e-6, 1e-12);
}

TEST(StepBounds, AreTheWidestInTheThirdSubStepAtTheLatest) {
  const Bench bench(kStick, kObject);
  const StepParameters& parameters = bench.model().parameters();
  StepBounds bounds = FirstBounds(bench.model(), Target{});
  bounds = NextBounds(parameters, bounds, 1.0, 1e9);
  EXPECT_LT(bounds.translation, parameters.widest_step);
  bounds = NextBounds(parameters, bounds, 1.0, 1e9);
  EXPECT_EQ(bounds.translation, parameters.widest_step);
  EXPECT_EQ(bounds.rotation, parameters.max_rotation);
}

TEST(StepBounds, GrowByWhatTheLooksPayFor) {
  const Bench bench(kStick, kObject);
  const StepParameters& parameters = bench.model().parameters();
  const StepBounds bounds{20e-6, 1e-4};
  EXPECT_NEAR(NextBounds(parameters, bounds, 1.0, 3.0).translation, 60e-6, 1e-18);
  EXPECT_NEAR(NextBounds(parameters, bounds, 1.0, 3.0).rotation, 3e-4, 1e-18);
  EXPECT_NEAR(NextBounds(parameters, bounds, 1.0, 0.5).translation, 10e-6, 1e-18);
}

TEST(StepBounds, AreThePartOfTheWayThatWasFreeAndAtLeastAQuarter) {
  const Bench bench(kStick, kObject);
  const StepParameters& parameters = bench.model().parameters();
  const StepBounds bounds{20e-6, 1e-4};
  EXPECT_NEAR(NextBounds(parameters, bounds, 0.5, 9.0).translation, 10e-6, 1e-18);
  EXPECT_NEAR(NextBounds(parameters, bounds, 0.0, 9.0).translation, 5e-6, 1e-18);
  // But not shorter than the separation: it has as many near pairs.
  const StepBounds least{1.5 * parameters.separation, 1e-5};
  EXPECT_NEAR(NextBounds(parameters, least, 0.0, 9.0).translation, parameters.separation, 1e-18);
}

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
