#include "devices/wrench_limiter.h"

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "common/error.h"
#include "devices/simulated/phantom_sheets.h"
#include "tests/support/allocation_counter.h"

namespace palpate {
namespace {

constexpr double kTick = 1e-3;
constexpr double kNever = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

WrenchLimits PhantomLimits() {
  return WrenchLimits::Of(PhantomPremium30().info);
}

/// A limiter in the middle of a session: enabled, replies fresh, ramps over.
WrenchLimiter Running(const Wrench& wrench) {
  WrenchLimiter limiter(PhantomLimits());
  limiter.Enable(true);
  for (int i = 0; i < 300; ++i) limiter.Limit(wrench, 0.5e-3, kTick);
  return limiter;
}

Wrench Force(double x, double y = 0.0, double z = 0.0) {
  return {Vec3(x, y, z), Vec3::Zero()};
}

/// Numbers that a broken producer may send.
class Adversary {
 public:
  explicit Adversary(unsigned seed) : random_(seed) {}

  double Number() {
    static const std::vector<double> kNasty = {0.0,    -0.0,   kNan,   kNever,  -kNever, 1e308,
                                               -1e308, 1e-308, 5e-324, -5e-324, 22.0,    -22.0};
    switch (Pick(4)) {
      case 0:
        return kNasty[Pick(kNasty.size())];
      case 1:
        return std::ldexp(Unit(), static_cast<int>(Pick(2000)) - 1000);
      case 2:
        return (Pick(2) ? 1.0 : -1.0) * 1e3;
      default:
        return 30.0 * Unit();
    }
  }
  Vec3 Vector() { return Vec3(Number(), Number(), Number()); }
  double Age() {
    static const std::vector<double> kAges = {0.0,  0.5e-3, 1e-3, 9e-3,   0.011, 0.02, 0.0299,
                                              0.03, 1.0,    -1.0, kNever, kNan,  1e308};
    return kAges[Pick(kAges.size())];
  }
  double Dt() {
    static const std::vector<double> kTicks = {kTick, kTick, kTick, 0.0,    2e-3,
                                               1.0,   -1.0,  kNan,  kNever, 1e-9};
    return kTicks[Pick(kTicks.size())];
  }
  std::size_t Pick(std::size_t n) {
    return std::uniform_int_distribution<std::size_t>(0, n - 1)(random_);
  }
  double Unit() { return std::uniform_real_distribution<double>(-1.0, 1.0)(random_); }

 private:
  std::mt19937 random_;
};

TEST(WrenchLimiter, KeepsForceAndStepInBoundsWhateverItIsGiven) {
  const WrenchLimits limits = PhantomLimits();
  for (unsigned seed = 0; seed < 40; ++seed) {
    Adversary adversary(seed);
    WrenchLimiter limiter(limits);
    Wrench last;
    bool calm = false;  // long quiet stretches, so that the gains do reach 1
    for (int i = 0; i < 5000; ++i) {
      if (adversary.Pick(300) == 0) calm = !calm;
      if (!calm && adversary.Pick(10) == 0) limiter.Enable(adversary.Pick(2) == 0);
      if (calm) limiter.Enable(true);
      const double dt = calm ? kTick : adversary.Dt();
      const double age = calm ? 1e-3 : adversary.Age();
      const Wrench out = limiter.Limit({adversary.Vector(), adversary.Vector()}, age, dt).wrench();
      ASSERT_TRUE(out.force.allFinite() && out.torque.allFinite()) << "seed " << seed << " i " << i;
      ASSERT_LE(out.force.norm(), limits.force_N);
      ASSERT_LE(out.torque.norm(), limits.torque_Nm);
      // The longest tick that counts is 2 ms.
      const double ms = dt > 0.0 ? std::min(dt, WrenchLimiter::kMaxTick_s) * 1e3 : 0.0;
      ASSERT_LE((out.force - last.force).norm(),
                limits.force_slew_N_per_ms * ms * (1 + 1e-12) + 1e-12)
          << "seed " << seed << " i " << i;
      ASSERT_LE((out.torque - last.torque).norm(),
                limits.torque_slew_Nm_per_ms * ms * (1 + 1e-12) + 1e-13);
      last = out;
    }
  }
}

TEST(WrenchLimiter, HoldsTheSlewLimitWhenForceAgeAndEnableAllChangeAtOnce) {
  const WrenchLimits limits = PhantomLimits();
  WrenchLimiter limiter = Running(Force(22.0));
  Vec3 last = limiter.Limit(Force(22.0), 0.0, kTick).wrench().force;
  limiter.Enable(false);
  for (int i = 1; i <= 40; ++i) {
    const Vec3 now = limiter.Limit(Force(-22.0), 0.010 + i * kTick, kTick).wrench().force;
    EXPECT_LE((now - last).norm(), limits.force_slew_N_per_ms);
    last = now;
  }
  EXPECT_EQ(last, Vec3::Zero());
}

TEST(WrenchLimiter, PassesAnOrdinaryWrenchUnchanged) {
  const Wrench touch{Vec3(0.3, -1.2, 2.0), Vec3(0.01, 0.02, -0.03)};
  WrenchLimiter limiter = Running(touch);
  const Wrench out = limiter.Limit(touch, 0.5e-3, kTick).wrench();
  EXPECT_EQ(out.force, touch.force);
  EXPECT_EQ(out.torque, touch.torque);
}

TEST(WrenchLimiter, ShortensToThePeakAndKeepsTheDirection) {
  const Wrench too_much{Vec3(300.0, 400.0, 0.0), Vec3(0.0, 0.0, -9.0)};
  WrenchLimiter limiter = Running(too_much);
  const Wrench out = limiter.Limit(too_much, 0.0, kTick).wrench();
  EXPECT_NEAR((out.force - Vec3(13.2, 17.6, 0.0)).norm(), 0.0, 1e-12);
  EXPECT_NEAR((out.torque - Vec3(0.0, 0.0, -0.515)).norm(), 0.0, 1e-12);
  EXPECT_EQ(limiter.counts().clamped, limiter.counts().calls);
}

TEST(WrenchLimiter, GivesNothingBeforeTheFirstReply) {
  WrenchLimiter limiter(PhantomLimits());
  limiter.Enable(true);
  for (int i = 0; i < 1000; ++i) {
    EXPECT_EQ(limiter.Limit(Force(5.0), kNever, kTick).wrench().force, Vec3::Zero());
  }
  EXPECT_EQ(limiter.counts().fades, 0u);
  EXPECT_FALSE(limiter.fading());
}

TEST(WrenchLimiter, GivesNothingUntilEnabledAndThenRampsIn) {
  WrenchLimiter limiter(PhantomLimits());
  for (int i = 0; i < 1000; ++i) {
    EXPECT_EQ(limiter.Limit(Force(5.0), 0.0, kTick).wrench().force, Vec3::Zero());
  }
  limiter.Enable(true);
  for (int i = 1; i <= 200; ++i) {
    EXPECT_NEAR(limiter.Limit(Force(5.0), 0.0, kTick).wrench().force.x(), 5.0 * i / 200.0, 1e-9);
  }
  EXPECT_EQ(limiter.Limit(Force(5.0), 0.0, kTick).wrench().force.x(), 5.0);
}

TEST(WrenchLimiter, RampsOutWhenDisabled) {
  WrenchLimiter limiter = Running(Force(5.0));
  limiter.Enable(false);
  for (int i = 1; i <= 50; ++i) {
    EXPECT_NEAR(limiter.Limit(Force(5.0), 0.0, kTick).wrench().force.x(), 5.0 * (50 - i) / 50.0,
                1e-9);
  }
  EXPECT_EQ(limiter.Limit(Force(5.0), 0.0, kTick).wrench().force, Vec3::Zero());
}

TEST(WrenchLimiter, FadesAfterTenMillisecondsAndIsZeroByThirty) {
  WrenchLimiter limiter = Running(Force(10.0));
  double last = 10.0;
  for (int ms = 1; ms <= 40; ++ms) {
    const double now = limiter.Limit(Force(10.0), ms * kTick, kTick).wrench().force.x();
    if (ms <= 10) {
      EXPECT_EQ(now, 10.0) << ms;
    } else if (ms < 30) {
      EXPECT_LT(now, last) << ms;
      const double x = (30 - ms) / 20.0;
      EXPECT_NEAR(now, 10.0 * x * x * (3 - 2 * x), 1e-9) << ms;
    } else {
      EXPECT_EQ(now, 0.0) << ms;
    }
    last = now;
  }
  EXPECT_TRUE(limiter.fading());
  EXPECT_EQ(limiter.counts().fades, 1u);
}

TEST(WrenchLimiter, IsZeroByThirtyMillisecondsEvenFromTheOppositePeak) {
  WrenchLimiter limiter = Running(Force(-22.0));
  Vec3 out;
  for (int ms = 1; ms <= 30; ++ms)
    out = limiter.Limit(Force(22.0), ms * kTick, kTick).wrench().force;
  EXPECT_EQ(out, Vec3::Zero());
}

TEST(WrenchLimiter, StaysAtZeroUntilAFreshReplyComesAndThenRampsIn) {
  WrenchLimiter limiter = Running(Force(10.0));
  for (int ms = 1; ms <= 1000; ++ms) limiter.Limit(Force(10.0), ms * kTick, kTick);
  // Younger, but not fresh: a reply of 15 ms does not open it again.
  for (int i = 0; i < 100; ++i) {
    EXPECT_EQ(limiter.Limit(Force(10.0), 0.015, kTick).wrench().force, Vec3::Zero());
  }
  for (int i = 1; i <= 200; ++i) {
    EXPECT_NEAR(limiter.Limit(Force(10.0), 1e-3, kTick).wrench().force.x(), 10.0 * i / 200.0, 1e-9);
  }
  EXPECT_FALSE(limiter.fading());
}

TEST(WrenchLimiter, TreatsAnAgeThatIsNotATimeAsNoReply) {
  for (double age : {kNan, -1.0, kNever}) {
    WrenchLimiter limiter = Running(Force(10.0));
    Vec3 out;
    for (int ms = 0; ms < 30; ++ms) out = limiter.Limit(Force(10.0), age, kTick).wrench().force;
    EXPECT_EQ(out, Vec3::Zero()) << age;
  }
}

TEST(WrenchLimiter, CountsANonFiniteWrenchAsZero) {
  WrenchLimiter limiter = Running(Force(10.0));
  Vec3 out;
  for (int i = 0; i < 20; ++i) out = limiter.Limit(Force(10.0, kNan), 0.0, kTick).wrench().force;
  EXPECT_EQ(out, Vec3::Zero());
  EXPECT_EQ(limiter.counts().nonfinite, 20u);
}

TEST(WrenchLimiter, TakesAStallForNoMoreThanTwoMilliseconds) {
  WrenchLimiter limiter = Running(Force(0.0));
  const double force = limiter.Limit(Force(22.0), 0.0, 5.0).wrench().force.norm();
  EXPECT_GT(force, 0.0);
  EXPECT_LE(force, 2.0 * limiter.limits().force_slew_N_per_ms);
}

TEST(WrenchLimiter, SoftensNoTouchThatAHandCanMake) {
  // 1 N/mm hit at 0.5 m/s: 0.5 N more each millisecond.
  WrenchLimiter limiter = Running(Force(0.0));
  for (int i = 1; i <= 20; ++i) {
    EXPECT_EQ(limiter.Limit(Force(0.5 * i), 0.5e-3, kTick).wrench().force.x(), 0.5 * i);
  }
  EXPECT_EQ(limiter.counts().slewed, 0u);
}

TEST(WrenchLimiter, GivesTheSameBitsForTheSameInputs) {
  Adversary a(7), b(7);
  WrenchLimiter left(PhantomLimits()), right(PhantomLimits());
  left.Enable(true);
  right.Enable(true);
  for (int i = 0; i < 5000; ++i) {
    const auto step = [](Adversary& from, WrenchLimiter& limiter) {
      const Wrench wanted{from.Vector(), from.Vector()};
      const double age = from.Age();
      return limiter.Limit(wanted, age, from.Dt()).wrench();
    };
    const Wrench l = step(a, left);
    const Wrench r = step(b, right);
    ASSERT_EQ(l.force, r.force);
    ASSERT_EQ(l.torque, r.torque);
  }
}

TEST(WrenchLimiter, AllocatesNothing) {
  WrenchLimiter limiter = Running(Force(1.0));
  const std::uint64_t before = test::AllocationsOfThisThread();
  for (int i = 0; i < 100; ++i) limiter.Limit(Force(kNan, 1e308, i), i * kTick, kTick);
  EXPECT_EQ(test::AllocationsOfThisThread(), before);
}

TEST(WrenchLimiter, RefusesLimitsThatCannotBeKept) {
  EXPECT_THROW(WrenchLimiter(WrenchLimits{}), Error);
  WrenchLimits limits = PhantomLimits();
  limits.force_N = kNan;
  EXPECT_THROW(WrenchLimiter{limits}, Error);
  limits = PhantomLimits();
  limits.force_slew_N_per_ms = 1.0;  // less than the fade needs
  EXPECT_THROW(WrenchLimiter{limits}, Error);
  limits = PhantomLimits();
  limits.fade_end_s = limits.fade_start_s;
  EXPECT_THROW(WrenchLimiter{limits}, Error);
}

}  // namespace
}  // namespace palpate
