#include "devices/limiter/small_stages.h"

#include <limits>

#include <gtest/gtest.h>

#include "tests/devices/limiter/limiter_figures.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

using test::kInf;
using test::kNan;

TEST(FiniteStage, TakesAWrenchThatIsNotFiniteForZero) {
  FiniteStage stage;
  for (int i = 0; i < 6; ++i) {
    for (const double bad : {kNan, kInf, -kInf}) {
      Wrench wrench{Vec3(1, 2, 3), Vec3(4, 5, 6)};
      (i < 3 ? wrench.force : wrench.torque)[i % 3] = bad;
      const Wrench out = stage.Pass(wrench);
      EXPECT_EQ(out.force, Vec3::Zero());
      EXPECT_EQ(out.torque, Vec3::Zero());
    }
  }
  EXPECT_EQ(stage.count(), 18u);
  EXPECT_EQ(stage.Pass({Vec3(1e308, -5e-324, 0), Vec3::Zero()}).force, Vec3(1e308, -5e-324, 0));
  EXPECT_EQ(stage.count(), 18u);
}

TEST(ClampStage, ShortensToThePeakAndKeepsTheDirection) {
  ClampStage stage(22.0, 0.5);
  test::Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 direction = random.Direction();
    const double size = std::ldexp(random.Uniform(0.5, 1.0), random.Below(1000) - 500);
    const Wrench out = stage.Pass({size * direction, size * direction});
    EXPECT_LE(out.force.norm(), 22.0);
    EXPECT_LE(out.torque.norm(), 0.5);
    EXPECT_NEAR(out.force.norm(), std::min(size, 22.0), 1e-12);
    EXPECT_NEAR(out.force.dot(direction), out.force.norm(), 1e-12);
  }
}

TEST(ClampStage, TouchesNothingWithinAndCountsWhatItShortens) {
  ClampStage stage(22.0, 0.5);
  EXPECT_EQ(stage.Pass({Vec3(22, 0, 0), Vec3(0, 0.5, 0)}).force, Vec3(22, 0, 0));
  EXPECT_EQ(stage.count(), 0u);
  stage.Pass({Vec3(1, 0, 0), Vec3(0, 0.6, 0)});
  stage.Pass({Vec3(100, 0, 0), Vec3(0, 0.6, 0)});
  EXPECT_EQ(stage.count(), 2u);
}

TEST(SlewStage, ReachesAStepInTheTimeOfItsRateByAStraightWay) {
  SlewStage stage(1000.0, 10.0);
  const Vec3 far(3, 4, 0);
  for (int i = 1; i <= 5; ++i) {
    EXPECT_NEAR((stage.Pass({far, Vec3::Zero()}, 1e-3).force - far * i / 5.0).norm(), 0.0, 1e-12);
  }
  EXPECT_EQ(stage.Pass({far, Vec3::Zero()}, 1e-3).force, far);
  EXPECT_GE(stage.count(), 4u);
}

TEST(SlewStage, FollowsExactlyWhatIsSlowEnoughAndStandsWhileNoTimePasses) {
  SlewStage stage(1000.0, 10.0);
  for (int i = 0; i < 100; ++i) {
    const Wrench wanted{Vec3(0.9 * i, 0, 0), Vec3(0, 0, 0.009 * i)};
    const Wrench& out = stage.Pass(wanted, 1e-3);
    EXPECT_EQ(out.force, wanted.force);
    EXPECT_EQ(out.torque, wanted.torque);
  }
  EXPECT_EQ(stage.count(), 0u);
  EXPECT_EQ(stage.Pass({}, 0.0).force, Vec3(0.9 * 99, 0, 0));
}

TEST(EnableStage, IsOffUntilAskedAndRampsInAndSoonerOut) {
  EnableStage stage;
  for (int i = 0; i < 100; ++i) EXPECT_EQ(stage.Gain(1e-3), 0.0);
  stage.Enable(true);
  for (int i = 1; i <= 200; ++i) EXPECT_NEAR(stage.Gain(1e-3), i / 200.0, 1e-12);
  EXPECT_EQ(stage.Gain(1e-3), 1.0);
  const std::uint64_t held_back = stage.count();
  EXPECT_NEAR(static_cast<double>(held_back), 300.0, 1.0);
  stage.Enable(false);
  for (int i = 1; i <= 50; ++i) EXPECT_NEAR(stage.Gain(1e-3), (50 - i) / 50.0, 1e-12);
  EXPECT_EQ(stage.Gain(1e-3), 0.0);
}

}  // namespace
}  // namespace palpate
