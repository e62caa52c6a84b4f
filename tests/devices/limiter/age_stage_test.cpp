#include "devices/limiter/age_stage.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "tests/devices/limiter/limiter_figures.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

using test::kInf;
using test::kNan;
using test::kTick;

AgeStage Fresh() {
  AgeStage stage;
  for (int i = 0; i < 300; ++i) stage.Gain(0.5e-3, 1e-3, kTick);
  return stage;
}

double Smoothstep(double x) {
  return x * x * (3.0 - 2.0 * x);
}

TEST(AgeStage, IsZeroBeforeTheFirstReply) {
  AgeStage stage;
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(stage.Gain(kInf, kInf, kTick), 0.0);
  EXPECT_EQ(stage.fades(), 0u);
  EXPECT_FALSE(stage.fading());
}

TEST(AgeStage, MeltsFromFourMillisecondsOfSilenceToZeroByTwentyFiveAtAnyRate) {
  for (const double tick : {1e-3, 2.5e-4, 2e-3}) {
    AgeStage stage = Fresh();
    double last = 1.0;
    for (int i = 1; i * tick < 0.040; ++i) {
      const double silence = i * tick;
      const double gain = stage.Gain(silence, silence, tick);
      if (silence <= 0.004) {
        EXPECT_EQ(gain, 1.0) << silence;
      } else if (silence < 0.025) {
        EXPECT_NEAR(gain, Smoothstep((0.025 - silence) / 0.021), 1e-7) << silence;
        EXPECT_LT(gain, last);
      } else {
        EXPECT_EQ(gain, 0.0) << silence;
      }
      last = gain;
    }
    EXPECT_TRUE(stage.fading());
    EXPECT_EQ(stage.fades(), 1u);
  }
}

TEST(AgeStage, TakesASteadyRoundTripForNoFaultUpToSixtyMilliseconds) {
  AgeStage stage = Fresh();
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(stage.Gain(1e-3, 0.060, kTick), 1.0);
  for (int i = 0; i < 100; ++i) stage.Gain(1e-3, 0.080, kTick);
  EXPECT_NEAR(stage.Gain(1e-3, 0.080, kTick), 0.5, 1e-9);
  for (int i = 0; i < 100; ++i) stage.Gain(1e-3, 0.100, kTick);
  EXPECT_EQ(stage.Gain(1e-3, 0.100, kTick), 0.0);
}

TEST(AgeStage, StaysDownUntilAFreshReplyAndThenRampsIn) {
  AgeStage stage = Fresh();
  for (int ms = 1; ms <= 1000; ++ms) stage.Gain(ms * kTick, ms * kTick, kTick);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(stage.Gain(0.010, 0.010, kTick), 0.0);
  for (int i = 1; i <= 200; ++i) EXPECT_NEAR(stage.Gain(1e-3, 1e-3, kTick), i / 200.0, 1e-9);
  EXPECT_EQ(stage.Gain(1e-3, 1e-3, kTick), 1.0);
  EXPECT_FALSE(stage.fading());
}

TEST(AgeStage, TakesATimeThatIsNoneForNoReply) {
  for (const double none : {kNan, -1e-3, kInf, 1e308}) {
    for (const bool silence : {true, false}) {
      AgeStage stage = Fresh();
      double gain = 1.0;
      for (int ms = 0; ms < 15; ++ms) {
        gain = silence ? stage.Gain(none, 1e-3, kTick) : stage.Gain(1e-3, none, kTick);
      }
      EXPECT_EQ(gain, 0.0) << none;
    }
  }
}

TEST(AgeStage, NeverMovesFasterThanItSays) {
  test::Random random(3);
  AgeStage stage;
  double last = 0.0;
  for (int i = 0; i < 100'000; ++i) {
    const bool calm = random.Below(400) > 100;
    const double silence = calm ? 1e-3 : random.Uniform(-0.01, 0.05);
    const double age = calm ? 1e-3 : random.Uniform(-0.01, 0.15);
    const double dt = random.Uniform(0.0, 2e-3);
    const double gain = stage.Gain(silence, age, dt);
    ASSERT_GE(gain, 0.0);
    ASSERT_LE(gain, 1.0);
    ASSERT_LE(std::abs(gain - last), AgeStage::kFastest_1_s * dt + 1e-15);
    last = gain;
  }
}

}  // namespace
}  // namespace palpate
