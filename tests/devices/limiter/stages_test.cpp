#include "devices/limiter/stages.h"

#include <cmath>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "devices/limiter/energy_stage.h"
#include "tests/devices/limiter/limiter_figures.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

using test::kInf;
using test::kNan;
using test::kTick;
using test::PhantomLimits;

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

TemperatureStage PhantomMotors() {
  const WrenchLimits limits = PhantomLimits();
  return {{limits.force_N(), limits.continuous_force_N(), limits.thermal_time_s()},
          {limits.torque_Nm(), limits.continuous_torque_Nm(), limits.thermal_time_s()}};
}

/// Asks for `force_N` for `seconds` and applies what is allowed; returns the last.
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
  TemperatureStage stage = PhantomMotors();
  EXPECT_EQ(Press(stage, 22.0, 0.4), 22.0);  // 54 times the continuous loss: 0.5 after 0.6 s
  const double given = Press(stage, 22.0, 600.0);
  EXPECT_NEAR(given, 3.0, 1e-3);
  EXPECT_GE(given, 3.0 - 1e-9);
  EXPECT_NEAR(stage.warmth(), 1.0, 1e-3);
  EXPECT_GT(stage.count(), 500'000u);
}

TEST(TemperatureStage, NeverWarmsPastTheLimitWhateverIsWanted) {
  TemperatureStage stage = PhantomMotors();
  double warmest = 0.0;
  for (int i = 0; i < 400; ++i) {
    Press(stage, i % 3 == 0 ? 22.0 : 0.5 * (i % 40), 0.5);
    warmest = std::max(warmest, stage.warmth());
  }
  // One tick at the peak warms by (22/3)^2 1 ms / 60 s.
  EXPECT_LE(warmest, 1.0 + 1e-3);
  EXPECT_GT(warmest, 0.9);
}

TEST(TemperatureStage, HoldsNothingBackBelowTheContinuousForce) {
  TemperatureStage stage = PhantomMotors();
  EXPECT_EQ(Press(stage, 3.0, 600.0), 3.0);
  EXPECT_EQ(stage.count(), 0u);
}

TEST(TemperatureStage, BringsTheForceDownSmoothly) {
  TemperatureStage stage = PhantomMotors();
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
  TemperatureStage stage = PhantomMotors();
  EXPECT_NEAR(Press(stage, 22.0, 0.3, 1.0), 3.0, 1e-9);
  EXPECT_NEAR(stage.warmth(), 1.0, 0.1);  // overdrawn while the bound came down
}

TEST(TemperatureStage, TakesMotorsBeyondTheirLimitForMotorsAtIt) {
  for (const double report : {1.01, 1.2, 1e300, kInf}) {
    TemperatureStage at = PhantomMotors(), beyond = PhantomMotors();
    EXPECT_EQ(Press(beyond, 22.0, 0.3, report), Press(at, 22.0, 0.3, 1.0)) << report;
    EXPECT_EQ(beyond.warmth(), at.warmth()) << report;
  }
}

TEST(TemperatureStage, IgnoresAReportThatIsCoolerOrNone) {
  TemperatureStage plain = PhantomMotors(), told = PhantomMotors();
  Press(plain, 22.0, 10.0);
  for (const double report : {0.0, -1.0, kNan, -kInf}) Press(told, 22.0, 2.5, report);
  EXPECT_EQ(plain.warmth(), told.warmth());
}

TEST(TemperatureStage, KeepsForceAndTorqueApart) {
  TemperatureStage stage = PhantomMotors();
  Press(stage, 22.0, 100.0);
  const auto share = stage.Pass({Vec3(22, 0, 0), Vec3(0, 0, 0.515)}, kNan, kTick);
  EXPECT_LT(share.force, 0.2);
  EXPECT_EQ(share.torque, 1.0);
}

TEST(PassivityObserver, SumsHeldWrenchTimesWay) {
  test::Random random(5);
  PassivityObserver observer;
  Pose X;
  observer.Move(X);
  double given = 0.0, highest = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const Wrench held{random.InCube(3.0), random.InCube(0.1)};
    observer.Hold(held);
    const Vec3 step = random.InCube(1e-3), turn = random.InCube(1e-2);
    X = {X.p + step, (RotationExp(turn) * X.q).normalized()};
    if (i % 3 == 0) X.q.coeffs() *= -1.0;  // the same rotation
    observer.Move(X);
    given += held.force.dot(step) + held.torque.dot(turn);
    highest = std::max(highest, given);
  }
  EXPECT_NEAR(observer.energy_J(), -given, 1e-12);
  EXPECT_NEAR(observer.lowest_J(), -highest, 1e-12);
}

TEST(PassivityObserver, BooksNoWorkForALeapOrForTheFirstPose) {
  PassivityObserver observer;
  observer.Hold({Vec3(5, 0, 0), Vec3::Zero()});
  observer.Move({Vec3(0.3, 0, 0), Quat::Identity()});
  EXPECT_TRUE(observer.leapt());
  observer.Move({Vec3(0.4, 0, 0), Quat::Identity()});
  EXPECT_TRUE(observer.leapt());
  observer.Move({Vec3(0.4, 0, 0), RotationExp(Vec3(0, 1, 0))});
  EXPECT_TRUE(observer.leapt());
  EXPECT_EQ(observer.energy_J(), 0.0);
  observer.Move({Vec3(0.401, 0, 0), RotationExp(Vec3(0, 1, 0))});
  EXPECT_FALSE(observer.leapt());
  EXPECT_NEAR(observer.energy_J(), -5e-3, 1e-15);
}

TEST(PassivityObserver, PassesOverAPoseThatIsNoneAndBooksTheWayLater) {
  PassivityObserver observer;
  observer.Move({});
  observer.Hold({Vec3(5, 0, 0), Vec3::Zero()});
  for (const Pose& none :
       {Pose{Vec3(kNan, 0, 0), Quat::Identity()}, Pose{Vec3(1e300, 0, 0), {}},
        Pose{Vec3::Zero(), Quat(0, 0, 0, 0)}, Pose{Vec3::Zero(), Quat(kNan, 0, 0, 0)}}) {
    observer.Move(none);
    EXPECT_FALSE(observer.seen());
  }
  observer.Move({Vec3(-0.002, 0, 0), Quat::Identity()});
  EXPECT_TRUE(observer.seen());
  EXPECT_NEAR(observer.energy_J(), 0.010, 1e-15);
}

}  // namespace
}  // namespace palpate
