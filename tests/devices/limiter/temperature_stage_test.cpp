#include "devices/limiter/temperature_stage.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "devices/simulated/phantom_sheets.h"
#include "tests/devices/limiter/limiter_figures.h"

namespace palpate {
namespace {

using test::kNan;
using test::kTick;
using test::PhantomLimits;

/// Wants a force for so long, and takes what there is; the last of it.
double Press(TemperatureStage& stage, double force_N, double seconds, double reported = kNan) {
  double given = 0.0;
  for (int i = 0; i < static_cast<int>(seconds / kTick); ++i) {
    const Wrench wanted{Vec3(force_N, 0, 0), Vec3::Zero()};
    given = stage.Pass(wanted, reported, kTick).force * force_N;
    stage.Give({Vec3(given, 0, 0), Vec3::Zero()}, kTick);
  }
  return given;
}

TEST(MotorWarmth, FollowsTheFirstOrderModel) {
  // u = 0.5 for 30 s at a time constant of 60 s: u^2 (1 - exp(-1/2)).
  MotorWarmth warmth(20.0, 4.0, 60.0);
  for (int i = 0; i < 30'000; ++i) warmth.Give(2.0, kTick);
  EXPECT_NEAR(warmth.warmth(), 0.25 * (1.0 - std::exp(-0.5)), 1e-5);
  for (int i = 0; i < 60'000; ++i) warmth.Give(0.0, kTick);
  EXPECT_NEAR(warmth.warmth(), 0.25 * (1.0 - std::exp(-0.5)) * std::exp(-1.0), 1e-5);
}

TEST(TemperatureStage, GivesThePeakWhileCoolAndTheContinuousForceForEver) {
  TemperatureStage stage(PhantomLimits());
  EXPECT_EQ(Press(stage, 22.0, 0.4), 22.0);  // 54 times the continuous loss: 0.5 after 0.6 s
  const double given = Press(stage, 22.0, 600.0);
  EXPECT_NEAR(given, 3.0, 1e-3);
  EXPECT_GE(given, 3.0 - 1e-9);
  EXPECT_NEAR(stage.warmth(), 1.0, 1e-3);
  EXPECT_GT(stage.count(), 500'000u);
}

TEST(TemperatureStage, NeverWarmsPastTheLimitWhateverIsWanted) {
  TemperatureStage stage(PhantomLimits());
  double warmest = 0.0;
  for (int i = 0; i < 400; ++i) {
    Press(stage, i % 3 == 0 ? 22.0 : 0.5 * (i % 40), 0.5);
    warmest = std::max(warmest, stage.warmth());
  }
  // One tick's step at the peak: (22/3)^2 1 ms / 60 s.
  EXPECT_LE(warmest, 1.0 + 1e-3);
  EXPECT_GT(warmest, 0.9);
}

TEST(TemperatureStage, HoldsNothingBackBelowTheContinuousForce) {
  TemperatureStage stage(PhantomLimits());
  EXPECT_EQ(Press(stage, 3.0, 600.0), 3.0);
  EXPECT_EQ(stage.count(), 0u);
}

TEST(TemperatureStage, BringsTheForceDownSmoothly) {
  TemperatureStage stage(PhantomLimits());
  double last = 22.0, steepest = 0.0;
  for (int i = 0; i < 20'000; ++i) {
    const double given = Press(stage, 22.0, kTick);
    EXPECT_LE(given, last);
    steepest = std::max(steepest, last - given);
    last = given;
  }
  EXPECT_LE(steepest, 22.0 * TemperatureStage::kFastest_1_s * kTick);
}

TEST(TemperatureStage, BelievesADeviceThatIsWarmerThanTheModel) {
  TemperatureStage stage(PhantomLimits());
  EXPECT_NEAR(Press(stage, 22.0, 0.3, 1.0), 3.0, 1e-9);
  EXPECT_NEAR(stage.warmth(), 1.0, 0.1);  // while the bound came down, it was overdrawn
}

TEST(TemperatureStage, IgnoresAReportThatIsCoolerOrNone) {
  TemperatureStage plain(PhantomLimits()), told(PhantomLimits());
  Press(plain, 22.0, 10.0);
  for (const double report : {0.0, -1.0, 1.1, kNan, std::numeric_limits<double>::infinity()}) {
    Press(told, 22.0, 2.0, report);
  }
  EXPECT_EQ(plain.warmth(), told.warmth());
}

TEST(TemperatureStage, KeepsForceAndTorqueApart) {
  TemperatureStage stage(PhantomLimits());
  Press(stage, 22.0, 100.0);
  const auto share = stage.Pass({Vec3(22, 0, 0), Vec3(0, 0, 0.515)}, kNan, kTick);
  EXPECT_LT(share.force, 0.2);
  EXPECT_EQ(share.torque, 1.0);
}

}  // namespace
}  // namespace palpate
