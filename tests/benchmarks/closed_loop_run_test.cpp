#include "tests/benchmarks/closed_loop_run.h"

#include <gtest/gtest.h>

#include "server/session/scene_model.h"
#include "tests/benchmarks/delayed_slide.h"

namespace palpate::bench {
namespace {

const ClosedLoopScene& Wall() {
  static const ClosedLoopScene wall = MakeClosedLoopScene("wall");
  return wall;
}

TEST(ClosedLoop, TremblesAcrossANetworkAndComesToRestWithTheLocalModel) {
  ClosedLoopCase c{.delay_ms = 10.0, .passivity = false};
  EXPECT_TRUE(RunClosedLoop(Wall(), c).stable);
  c.local_model = false;
  const ClosedLoopFigures late = RunClosedLoop(Wall(), c);
  EXPECT_FALSE(late.stable);
  EXPECT_GT(late.limit_cycle_mm, 1.0);
  EXPECT_GT(late.energy_J, 0.01);
}

TEST(ClosedLoop, GivesTheHandNoEnergyBehindThePassivityController) {
  for (const bool local_model : {true, false}) {
    for (const double delay_ms : {0.0, 10.0}) {
      const ClosedLoopCase c{
          .delay_ms = delay_ms, .jitter_ms = 2.0, .loss = 0.02, .local_model = local_model};
      EXPECT_LT(RunClosedLoop(Wall(), c).energy_J, 1e-6) << delay_ms;
    }
  }
}

TEST(ClosedLoop, RepeatsToTheBit) {
  const ClosedLoopCase c{.delay_ms = 7.0, .jitter_ms = 5.0, .loss = 0.1};
  const ClosedLoopFigures once = RunClosedLoop(Wall(), c), again = RunClosedLoop(Wall(), c);
  EXPECT_EQ(once.limit_cycle_mm, again.limit_cycle_mm);
  EXPECT_EQ(once.energy_J, again.energy_J);
  EXPECT_EQ(once.mean_force_N, again.mean_force_N);
}

TEST(DelayedSlide, IsTheServersOwnStepOnAPlane) {
  const Scene& scene = Wall().scene;
  const HapticModel model = MakeModel(scene, scene.tools.front(), MakeObjects(scene));
  std::vector<Pose> way;
  for (int i = 0; i <= 100; ++i) {
    way.push_back({Vec3(1e-4 * i - 5e-3, 3e-3 + 1e-5 * (i % 50), 2e-5 * i), Quat::Identity()});
  }
  for (const int delay_ms : {0, 5, 10, 20}) {
    const SlideErrors errors = MeasureDelayedSlide(model, AtSpeed(way, 0.1), {0.1, delay_ms});
    ASSERT_GT(errors.ticks, 50u);
    EXPECT_LT(errors.local.max, 1e-6) << delay_ms;
    if (delay_ms > 0) {
      EXPECT_GT(errors.late.max, 0.01) << delay_ms;
    }
  }
}

}  // namespace
}  // namespace palpate::bench
