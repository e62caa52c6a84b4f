#include "tests/benchmarks/closed_loop_run.h"

#include <gtest/gtest.h>

#include "devices/limiter/energy_stage.h"
#include "scenes/catalogue.h"
#include "server/physics/scene_model.h"
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

TEST(ClosedLoop, ComesToRestThoughTheHandBouncesFurtherThanRowsReach) {
  // A light hand, once released, flies off by centimetres, and meets the wall a round trip late if
  // the local model has forgotten it.
  const ClosedLoopCase c{
      .hand = "light", .delay_ms = 10.0, .passivity = false, .stiffness_N_per_m = 5000.0};
  EXPECT_TRUE(RunClosedLoop(Wall(), c).stable);
}

TEST(ClosedLoop, GivesTheHandNoEnergyBehindThePassivityController) {
  for (const bool local_model : {true, false}) {
    for (const double delay_ms : {0.0, 5.0, 10.0, 20.0}) {
      for (const double stiffness : {1000.0, 5000.0}) {
        const ClosedLoopFigures figures = RunClosedLoop(Wall(), {.delay_ms = delay_ms,
                                                                 .jitter_ms = 2.0,
                                                                 .loss = 0.1,
                                                                 .local_model = local_model,
                                                                 .stiffness_N_per_m = stiffness});
        EXPECT_LE(figures.energy_end_J, 0.0) << delay_ms;
        EXPECT_LE(figures.energy_seen_J, EnergyStage::kSeed_J) << delay_ms;
        // What the encoder cannot resolve: 3 N over a step of 20 um.
        EXPECT_LT(figures.energy_J, 60e-6) << delay_ms;
      }
    }
  }
}

TEST(ClosedLoop, CountsTheEnergyThatIsGivenOnTheWayOut) {
  // Leaving a late wall returns more energy than entering took: seen only once the hand leaves.
  const ClosedLoopCase c{
      .delay_ms = 10.0, .local_model = false, .passivity = false, .stiffness_N_per_m = 600.0};
  const ClosedLoopFigures figures = RunClosedLoop(Wall(), c);
  EXPECT_TRUE(figures.stable);
  EXPECT_GT(figures.energy_end_J, 1e-4);
}

TEST(ClosedLoop, TellsHowMuchOfAWallIsLeftWhereTheControllerHoldsItBack) {
  ClosedLoopCase c{.delay_ms = 20.0, .local_model = false, .stiffness_N_per_m = 20'000.0};
  EXPECT_LT(RunClosedLoop(Wall(), c).rendered, 0.5);
  c.delay_ms = 0.0;
  c.stiffness_N_per_m = 1000.0;
  EXPECT_GT(RunClosedLoop(Wall(), c).rendered, 0.99);
}

TEST(ClosedLoop, HoldsABunnyBesideItsReferenceByAStiffnessThatGrowsWithTheCoupling) {
  // With a fixed torsional spring every contact beside the reference would be soft, and stable.
  const ClosedLoopScene bunny = MakeClosedLoopScene("bunny");
  ClosedLoopCase c{
      .delay_ms = 10.0, .local_model = false, .passivity = false, .stiffness_N_per_m = 10'000.0};
  EXPECT_FALSE(RunClosedLoop(bunny, c).stable);
  c.local_model = true;
  EXPECT_TRUE(RunClosedLoop(bunny, c).stable);
}

TEST(ClosedLoop, RepeatsToTheBit) {
  const ClosedLoopCase c{.delay_ms = 7.0, .jitter_ms = 5.0, .loss = 0.1};
  const ClosedLoopFigures once = RunClosedLoop(Wall(), c), again = RunClosedLoop(Wall(), c);
  EXPECT_EQ(once.limit_cycle_mm, again.limit_cycle_mm);
  EXPECT_EQ(once.energy_J, again.energy_J);
  EXPECT_EQ(once.mean_force_N, again.mean_force_N);
}

TEST(DelayedSlide, TakesEverySeedAnotherWayOverTheBunnyAndEachTwiceTheSame) {
  const Scene scene = LoadScene("bunny-bunny");
  const HapticModel model = MakeModel(scene, scene.tools.front(), MakeObjects(scene));
  const std::vector<SlidePath> once = SlidePaths(model, 3, 5, 0.03);
  const std::vector<SlidePath> again = SlidePaths(model, 1, 6, 0.03);
  ASSERT_EQ(once.size(), 4u);
  for (std::size_t i = 1; i < once.size(); ++i) {
    const SlideTicks ticks = MeasureDelayedSlide(model, AtSpeed(once[i].hand, 0.1), {0.1, 10});
    const SlideErrors errors = ErrorsOf({&ticks, 1});
    EXPECT_GT(errors.contact, 0.5) << once[i].name;
    EXPECT_GT(errors.mean_force_N, 1.0) << once[i].name;
    EXPECT_LT(errors.mean_force_N, 4.0) << once[i].name;
  }
  EXPECT_NE(once[1].hand.back().p, once[2].hand.back().p);
  EXPECT_EQ(once[2].hand.back().p, again[1].hand.back().p);
}

TEST(DelayedSlide, IsTheServersOwnStepOnAPlane) {
  const Scene& scene = Wall().scene;
  const HapticModel model = MakeModel(scene, scene.tools.front(), MakeObjects(scene));
  std::vector<Pose> way;
  for (int i = 0; i <= 100; ++i) {
    way.push_back({Vec3(1e-4 * i - 5e-3, 3e-3 + 1e-5 * (i % 50), 2e-5 * i), Quat::Identity()});
  }
  for (const int delay_ms : {0, 5, 10, 20}) {
    const SlideTicks ticks = MeasureDelayedSlide(model, AtSpeed(way, 0.1), {0.1, delay_ms});
    const SlideErrors errors = ErrorsOf({&ticks, 1});
    ASSERT_GT(errors.ticks, 50u);
    // The step leaves a touching tool between h and delta, half a micrometre, off the plane
    // (limits::mesh); the paths are at least 5 mm deep.
    EXPECT_LT(errors.local.max, 0.5e-6 / 5e-3) << delay_ms;
    if (delay_ms > 0) {
      EXPECT_GT(errors.late.max, 0.01) << delay_ms;
    }
  }
}

}  // namespace
}  // namespace palpate::bench
