#include "devices/wrench_limiter.h"

#include <cstdlib>
#include <type_traits>
#include <utility>

#include <gtest/gtest.h>

#include "common/error.h"
#include "tests/devices/limiter/limiter_figures.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/limiter_adversary.h"
#include "tests/support/optimised.h"
#include "tests/support/uncontrolled_limiter.h"

namespace palpate {
namespace {

using test::kInf;
using test::kNan;
using test::kTick;
using test::PhantomLimits;

TEST(WrenchLimits, AreTheDataSheets) {
  const WrenchLimits limits = PhantomLimits();
  EXPECT_EQ(limits.force_N(), 22.0);
  EXPECT_EQ(limits.continuous_force_N(), 3.0);
  EXPECT_EQ(limits.torque_Nm(), 0.515);
  EXPECT_EQ(limits.continuous_torque_Nm(), 0.188);
  EXPECT_EQ(limits.force_slew_N_per_ms(), 4.4);
}

TEST(WrenchLimits, RefuseADataSheetThatSaysNothingOrNonsense) {
  const auto refused = [](auto change) {
    DeviceInfo info = PhantomPremium30().info;
    change(info);
    EXPECT_THROW(WrenchLimits::Of(info), Error);
  };
  refused([](DeviceInfo& info) { info = DeviceInfo{}; });
  for (const double nonsense : {0.0, -1.0, kNan, kInf}) {
    refused([&](DeviceInfo& info) { info.max_force_N = nonsense; });
    refused([&](DeviceInfo& info) { info.max_torque_Nm = nonsense; });
    refused([&](DeviceInfo& info) { info.continuous_force_N = nonsense; });
    refused([&](DeviceInfo& info) { info.continuous_torque_Nm = nonsense; });
    refused([&](DeviceInfo& info) { info.thermal_time_s = nonsense; });
  }
  refused([](DeviceInfo& info) { info.continuous_force_N = 23.0; });  // above the peak
  refused([](DeviceInfo& info) { info.thermal_time_s = 0.06; });
}

TEST(WrenchLimits, AreTightenedByAForceAndNeverLoosened) {
  const DeviceInfo info = PhantomPremium30().info;
  const WrenchLimits limits = WrenchLimits::Of(info, 2.2);
  EXPECT_DOUBLE_EQ(limits.force_N(), 2.2);
  EXPECT_DOUBLE_EQ(limits.continuous_force_N(), 2.2);
  EXPECT_DOUBLE_EQ(limits.torque_Nm(), 0.0515);
  EXPECT_DOUBLE_EQ(limits.continuous_torque_Nm(), 0.0515);
  EXPECT_EQ(limits.force_slew_N_per_ms(), 4.4) << "a touch is softened no more than before";
  EXPECT_EQ(WrenchLimits::Of(info, 0.5).bounds().led_force_N, 0.5);
  EXPECT_EQ(WrenchLimits::Of(info, 50.0).force_N(), 22.0);
  EXPECT_EQ(WrenchLimits::Of(info, 50.0).torque_Nm(), 0.515);
  for (const double none : {0.0, -1.0, kNan}) EXPECT_THROW(WrenchLimits::Of(info, none), Error);
}

/// A handle held still, with replies as old as the silence.
LimiterInput Input(const Wrench& wanted, double age_s, double dt_s) {
  return {wanted, {}, {}, {}, age_s, age_s, dt_s};
}

/// A limiter in the middle of a session: enabled, with fresh replies and its ramps over.
WrenchLimiter Running(const Wrench& wrench) {
  WrenchLimiter limiter(PhantomLimits());
  limiter.Enable(true);
  for (int i = 0; i < 300; ++i) limiter.Limit(Input(wrench, 0.5e-3, kTick));
  return limiter;
}

Wrench Force(double x, double y = 0.0, double z = 0.0) {
  return {Vec3(x, y, z), Vec3::Zero()};
}

/// PALPATE_LIMITER_INPUTS=100000000 makes a long run.
std::uint64_t InputsToTry() {
  const char* const asked = std::getenv("PALPATE_LIMITER_INPUTS");
  if (asked != nullptr) return std::strtoull(asked, nullptr, 10);
  return test::kOptimised ? 1'000'000 : 400'000;
}

TEST(WrenchLimiter, KeepsItsLimitsWhateverItIsGiven) {
  for (const bool tight : {false, true}) {
    const WrenchLimits limits =
        tight ? WrenchLimits::Of(PhantomPremium30().info, 5.0) : PhantomLimits();
    const test::LimiterTally tally = test::LimiterAdversary(limits, tight).Run(InputsToTry());
    EXPECT_EQ(tally.nonfinite, 0u);
    EXPECT_LE(tally.force, 1.0);
    EXPECT_LE(tally.torque, 1.0);
    EXPECT_LE(tally.force_slew, 1.0);
    EXPECT_LE(tally.torque_slew, 1.0);
    // It came near the limits, and every stage acted.
    EXPECT_GT(tally.force, 0.99);
    EXPECT_GT(tally.force_slew, 0.8);
    const LimiterCounts& counts = tally.counts;
    for (const std::uint64_t count :
         {counts.nonfinite, counts.clamped, counts.slewed, counts.braked, counts.warm, counts.faded,
          counts.fades, counts.disabled}) {
      EXPECT_GT(count, 100u);
    }
  }
}

TEST(WrenchLimiter, PassesAnOrdinaryWrenchUnchanged) {
  const Wrench touch{Vec3(0.3, -1.2, 2.0), Vec3(0.01, 0.02, -0.03)};
  WrenchLimiter limiter = Running(touch);
  const Wrench out = limiter.Limit(Input(touch, 0.5e-3, kTick)).wrench();
  EXPECT_EQ(out.force, touch.force);
  EXPECT_EQ(out.torque, touch.torque);
}

TEST(WrenchLimiter, IsZeroByTwentyFiveMillisecondsOfSilenceEvenFromTheOppositePeak) {
  for (const double before : {10.0, -22.0}) {
    WrenchLimiter limiter = Running(Force(before));
    Vec3 out;
    for (int ms = 1; ms <= 25; ++ms) {
      out = limiter.Limit(Input(Force(22.0), ms * kTick, kTick)).wrench().force;
    }
    EXPECT_EQ(out, Vec3::Zero());
    EXPECT_TRUE(limiter.fading());
    EXPECT_EQ(limiter.counts().fades, 1u);
  }
}

TEST(WrenchLimiter, TakesAStallForNoMoreThanTwoMilliseconds) {
  WrenchLimiter limiter = Running(Force(0.0));
  const double force = limiter.Limit(Input(Force(22.0), 0.0, 5.0)).wrench().force.norm();
  EXPECT_GT(force, 0.0);
  EXPECT_LE(force, 2.0 * limiter.limits().force_slew_N_per_ms());
}

TEST(WrenchLimiter, SoftensNoTouchThatAHandCanMake) {
  // 1 N/mm hit at 0.5 m/s: 0.5 N more each millisecond.
  WrenchLimiter limiter = Running(Force(0.0));
  for (int i = 1; i <= 20; ++i) {
    EXPECT_EQ(limiter.Limit(Input(Force(0.5 * i), 0.5e-3, kTick)).wrench().force.x(), 0.5 * i);
  }
  EXPECT_EQ(limiter.counts().slewed, 0u);
}

TEST(WrenchLimiter, GivesTheSameBitsForTheSameInputs) {
  const auto run = [] { return test::LimiterAdversary(PhantomLimits(), 7).Run(50'000); };
  const test::LimiterTally a = run(), b = run();
  EXPECT_EQ(a.force_slew, b.force_slew);
  EXPECT_EQ(a.torque_slew, b.torque_slew);
  EXPECT_EQ(a.counts.braked, b.counts.braked);
  EXPECT_EQ(a.counts.warm, b.counts.warm);
}

TEST(WrenchLimiter, BoundsWhatAGuideAddsAndKeepsItOutOfTheAccount) {
  WrenchLimiter limiter(PhantomLimits());
  limiter.Enable(true);
  LimiterInput in = Input({}, 0.0, kTick);
  in.led.force = Vec3(100, 0, 0);
  Vec3 out;
  for (int i = 0; i < 1000; ++i) {
    in.X_WH.p.x() += 1e-4;  // the hand follows
    out = limiter.Limit(in).wrench().force;
  }
  EXPECT_NEAR(out.x(), 1.0, 1e-12);
  EXPECT_EQ(limiter.observer().energy_J(), 0.0);
  EXPECT_EQ(limiter.counts().braked, 0u);
}

TEST(WrenchLimiter, KeepsContactAndGuideTogetherWithinThePeak) {
  WrenchLimiter limiter(PhantomLimits());
  limiter.Enable(true);
  LimiterInput in = Input(Force(22.0), 0.0, kTick);
  in.led.force = Vec3(1, 0, 0);
  for (int i = 0; i < 300; ++i) EXPECT_LE(limiter.Limit(in).wrench().force.norm(), 22.0);
}

TEST(WrenchLimiter, IsNotReplacedByOneThatCanBeSwitchedOff) {
  // Only WrenchLimiter makes what a device takes; the chain without a controller returns a Wrench.
  static_assert(!std::is_constructible_v<LimitedWrench, const Wrench&>);
  static_assert(!std::is_default_constructible_v<LimitedWrench>);
  static_assert(!std::is_default_constructible_v<WrenchLimits>);
  static_assert(
      std::is_same_v<decltype(std::declval<test::UncontrolledLimiter>().Limit({})), Wrench>);
}

TEST(WrenchLimiter, HeatsByWhatIsAppliedInTheEnd) {
  WrenchLimiter off(PhantomLimits());
  for (int i = 0; i < 5000; ++i) off.Limit(Input(Force(22.0), 0.0, kTick));
  EXPECT_EQ(off.warmth(), 0.0);
  WrenchLimiter on = Running(Force(22.0));
  for (int i = 0; i < 60'000; ++i) on.Limit(Input(Force(22.0), 0.0, kTick));
  EXPECT_NEAR(on.Limit(Input(Force(22.0), 0.0, kTick)).wrench().force.norm(), 3.0, 0.1);
}

TEST(WrenchLimiter, AllocatesNothing) {
  WrenchLimiter limiter = Running(Force(1.0));
  const std::uint64_t before = test::AllocationsOfThisThread();
  for (int i = 0; i < 100; ++i) limiter.Limit(Input(Force(kNan, 1e308, i), i * kTick, kTick));
  EXPECT_EQ(test::AllocationsOfThisThread(), before);
}

}  // namespace
}  // namespace palpate
