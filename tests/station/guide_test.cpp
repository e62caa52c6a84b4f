#include "client/station/guide.h"

#include <limits>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "tests/support/milliseconds.h"
#include "tests/support/random.h"

namespace palpate::test {
namespace {

constexpr double kForce_N = 0.5;

class GuideTest : public testing::Test {
 protected:
  void Aim(const Vec3& p, const Quat& q = Quat::Identity(), std::uint64_t run = 1) {
    guide_.Take(now_ns_, {run, {p, q}});
  }
  Wrench Pull(const Vec3& hand, const Vec3& v = Vec3::Zero()) {
    now_ns_ += kMs;
    return guide_.Pull(now_ns_, 1e-3, {hand, Quat::Identity()}, {v, Vec3::Zero()});
  }
  /// Pulls a hand that moves along, fast enough not to resist.  Returns the last wrench.
  Wrench PullWilling(const Vec3& aim, const Vec3& hand, int milliseconds) {
    Wrench wrench;
    for (int i = 0; i < milliseconds; ++i) {
      Aim(aim);
      const Vec3 e = aim - hand;
      wrench = Pull(hand, e.norm() > 0.0 ? Vec3(0.05 * e.normalized()) : Vec3::Zero());
    }
    return wrench;
  }

  std::int64_t now_ns_ = 1000 * kMs;
  Guide guide_{GuideLimits::OfForce(kForce_N)};
};

TEST_F(GuideTest, PullsTowardsTheAimInProportionAndNoMoreThanItsLimit) {
  EXPECT_NEAR(PullWilling(Vec3(0.002, 0, 0), Vec3::Zero(), 600).force.x(), 0.2, 1e-9);
  EXPECT_NEAR(PullWilling(Vec3(0.005, 0, 0), Vec3::Zero(), 600).force.x(), 0.5, 1e-9);
  const Wrench far = PullWilling(Vec3(0, 0.015, 0), Vec3::Zero(), 600);
  EXPECT_NEAR(far.force.y(), 0.5, 1e-9);
  EXPECT_NEAR(far.force.norm(), 0.5, 1e-9);
}

TEST_F(GuideTest, TurnsTowardsTheAimWithAHundredthOfTheForce) {
  Wrench wrench;
  for (int i = 0; i < 600; ++i) {
    Aim(Vec3::Zero(), RotationExp(Vec3(0, 0, 1.0)));
    wrench = Pull(Vec3::Zero());
  }
  EXPECT_NEAR(wrench.torque.z(), 0.005, 1e-9);
}

TEST_F(GuideTest, ComesInByARamp) {
  double last = 0.0;
  for (int i = 1; i <= 500; ++i) {
    Aim(Vec3(0.004, 0, 0));
    const double now = Pull(Vec3::Zero()).force.norm();
    EXPECT_LE(now - last, 0.4 / 500 + 1e-9);
    last = now;
  }
  EXPECT_NEAR(last, 0.4, 1e-6);
}

TEST_F(GuideTest, IsGoneAHundredMillisecondsAfterItFallsSilent) {
  const Vec3 aim(0.004, 0, 0);
  PullWilling(aim, Vec3::Zero(), 600);
  double last = 0.4;
  for (int i = 1; i <= 300; ++i) {
    const double now = Pull(Vec3::Zero()).force.norm();
    EXPECT_LE(now, last + 1e-12);
    if (i < 49) {
      EXPECT_NEAR(now, 0.4, 1e-9) << "aims come ten times as often";
    }
    if (i >= 99) {
      EXPECT_EQ(now, 0.0) << i;
    }
    last = now;
  }
}

TEST_F(GuideTest, LetsGoOfAHandThatResistsUntilTheHandReturns) {
  const Vec3 aim(0.010, 0, 0);
  PullWilling(aim, Vec3::Zero(), 600);
  double last = 0.5;
  for (int i = 1; i <= 3000; ++i) {
    Aim(aim);
    const double now = Pull(Vec3::Zero(), Vec3(-0.01, 0, 0)).force.norm();
    EXPECT_LE(now, last + 1e-12) << "never more while it resists";
    if (i >= 800) {
      EXPECT_EQ(now, 0.0) << i;
    }
    last = now;
  }
  EXPECT_TRUE(guide_.let_go());
  EXPECT_EQ(PullWilling(aim, Vec3::Zero(), 2000).force.norm(), 0.0) << "the hand has not returned";
  EXPECT_LT(PullWilling(aim, Vec3(0.006, 0, 0), 1).force.norm(), 0.01) << "a ramp, not a step";
  EXPECT_FALSE(guide_.let_go());
  EXPECT_NEAR(PullWilling(aim, Vec3(0.006, 0, 0), 600).force.norm(), 0.4, 1e-9);
}

TEST_F(GuideTest, StaysOverruledWhateverComes) {
  const Vec3 aim(0.010, 0, 0);
  PullWilling(aim, Vec3::Zero(), 600);
  for (int i = 1; i <= 1000; ++i) {
    Aim(aim);
    Pull(Vec3::Zero(), Vec3(-0.01, 0, 0));
  }
  ASSERT_TRUE(guide_.let_go());
  for (int i = 0; i < 150; ++i) Pull(Vec3::Zero());  // silence
  EXPECT_EQ(PullWilling(aim, Vec3::Zero(), 1000).force.norm(), 0.0);
  EXPECT_EQ(PullWilling(Vec3(0.05, 0, 0), Vec3::Zero(), 1000).force.norm(), 0.0) << "a leap";
  Aim(aim, Quat::Identity(), 2);
  EXPECT_EQ(Pull(Vec3::Zero()).force.norm(), 0.0) << "another guide";
  EXPECT_TRUE(guide_.let_go());
}

TEST_F(GuideTest, DoesNotTakeAHandThatFollowsForOneThatResists) {
  for (int i = 0; i < 3000; ++i) {
    const Vec3 hand(2e-5 * i, 0, 0);
    Aim(hand + Vec3(0.010, 0, 0));
    const Wrench wrench = Pull(hand, Vec3(0.02, 0, 0));
    if (i > 600) {
      EXPECT_NEAR(wrench.force.x(), 0.5, 1e-9);
    }
  }
}

TEST_F(GuideTest, RampsInAnewWhereTheAimLeaps) {
  PullWilling(Vec3(0.004, 0, 0), Vec3::Zero(), 600);
  EXPECT_LT(PullWilling(Vec3(-0.03, 0, 0), Vec3::Zero(), 1).force.norm(), 0.01);
  PullWilling(Vec3(0.004, 0, 0), Vec3::Zero(), 600);
  Aim(Vec3(0.004, 0, 0), Quat::Identity(), 2);
  EXPECT_LT(Pull(Vec3::Zero()).force.norm(), 0.01) << "another guide";
  PullWilling(Vec3::Zero(), Vec3::Zero(), 600);
  Aim(Vec3::Zero(), Quat(Eigen::AngleAxisd(3.0, Vec3::UnitZ())));
  EXPECT_LT(Pull(Vec3::Zero()).torque.norm(), 1e-4) << "a turn";
}

TEST(GuideLimits, AreNeverAboveWhatAHandMayAlwaysOverrule) {
  EXPECT_EQ(GuideLimits::OfForce(5.0).force_N, GuideLimits::kMostForce_N);
  EXPECT_EQ(GuideLimits::OfForce(0.5).torque_Nm, 0.005);
  EXPECT_EQ(GuideLimits::OfForce(-1.0).force_N, 0.0);
  EXPECT_EQ(GuideLimits::OfForce(std::numeric_limits<double>::quiet_NaN()).force_N, 0.0);
}

TEST(Guide, ThatIsNotAcceptedDoesNothing) {
  Guide guide;
  guide.Take(0, {1, {Vec3(0.1, 0, 0), Quat::Identity()}});
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(guide.Pull(i * 10'000, 1e-3, {}, {}).force.norm(), 0.0);
}

TEST(Guide, StaysWithinItsLimitWhateverComes) {
  Random random(5);
  const double odd[] = {std::numeric_limits<double>::quiet_NaN(),
                        std::numeric_limits<double>::infinity(),
                        1e308,
                        -1e308,
                        0.0,
                        1e-320};
  const auto any = [&](double scale) {
    Vec3 v = random.InCube(scale);
    if (random.Below(20) == 0) v[random.Below(3)] = odd[random.Below(6)];
    return v;
  };
  int pulls = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const double force_N = random.Uniform(0.01, 2.0);
    const GuideLimits limits = GuideLimits::OfForce(force_N);
    Guide guide(limits);
    std::int64_t now_ns = static_cast<std::int64_t>(random.Bits() >> 2);
    std::int64_t heard_ns = 0;
    Vec3 hand = Vec3::Zero();
    for (int i = 0; i < 1000; ++i) {
      now_ns += random.Below(100) == 0 ? random.Below(400) * kMs : kMs;
      if (random.Below(3) > 0) {
        Quat q = random.Rotation();
        if (random.Below(20) == 0) q.coeffs()[random.Below(4)] = odd[random.Below(6)];
        guide.Take(now_ns, {static_cast<std::uint64_t>(random.Below(500) == 0), {any(0.02), q}});
        heard_ns = now_ns;
      }
      if (random.Below(50) == 0) hand = any(0.02);
      const double dt = random.Below(30) == 0 ? odd[random.Below(6)] : 1e-3;
      const Twist V{any(0.1), Vec3::Zero()};
      const Wrench wrench = guide.Pull(now_ns, dt, {hand, random.Rotation()}, V);
      ASSERT_LE(wrench.force.norm(), limits.force_N * (1 + 1e-12));
      ASSERT_LE(wrench.force.norm(), GuideLimits::kMostForce_N * (1 + 1e-12));
      ASSERT_LE(wrench.torque.norm(), limits.torque_Nm * (1 + 1e-12));
      ASSERT_TRUE(now_ns - heard_ns < Guide::kSilent_ns || wrench.force.norm() == 0.0);
      pulls += wrench.force.norm() > 0.0;
    }
  }
  EXPECT_GT(pulls, 1000);
}

}  // namespace
}  // namespace palpate::test
