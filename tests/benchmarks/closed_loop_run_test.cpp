#include "tests/benchmarks/closed_loop_run.h"

#include <gtest/gtest.h>

#include "devices/limiter/energy_stage.h"

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

}  // namespace
}  // namespace palpate::bench
