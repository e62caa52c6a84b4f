#include "client/crtk/crtk_station.h"

#include <algorithm>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate::test {
namespace {

using testing::HasSubstr;

TEST(RosNames, BeginWithNoDigit) {
  EXPECT_EQ(RosNamespace("hand"), "/hand");
  EXPECT_EQ(RosNamespace("7"), "/station_7");
}

TEST(RosNames, HaveNoTwoUnderscoresSideBySide) {
  for (const char* name : {"hand", "left_hand", "_hidden", "hand_", "7_", "a_b_c"}) {
    EXPECT_EQ(WhyNoRosName(name), "") << name;
  }
  for (const char* name : {"left__hand", "__", "a___b", "__hand", "hand__"}) {
    EXPECT_THAT(WhyNoRosName(name), HasSubstr("give the station an --id without it")) << name;
  }
}

constexpr std::int64_t kMs = 1'000'000;

/// What a station's guide pulls a hand at rest with, once it has ramped in.
Wrench PullOf(const Vec3& force, const Vec3& torque, const GuideLimits& limits) {
  const Pose X_WH{Vec3(0.1, -0.2, 0.3), Quat(0.5, 0.5, -0.5, 0.5)};
  Guide guide(limits);
  Wrench pull{};
  for (std::int64_t tick = 0; tick < 1000; ++tick) {
    const auto aim = ServoAim(X_WH, {force, torque}, limits);
    if (aim && tick % 5 == 0) guide.Take(tick * kMs, {1, *aim});
    pull = guide.Pull(tick * kMs, 1e-3, X_WH, {});
  }
  return pull;
}

TEST(ServoAim, MakesAStationPullWithTheWrenchThatWasAskedFor) {
  const GuideLimits limits = GuideLimits::OfForce(0.8);
  const Vec3 force(0.3, -0.4, 0.1), torque(0.001, 0.002, -0.004);
  const Wrench pull = PullOf(force, torque, limits);
  EXPECT_LT((pull.force - force).norm(), 1e-9);
  EXPECT_LT((pull.torque - torque).norm(), 1e-9);
}

TEST(ServoAim, ShortensWhatIsMoreThanTheLimitAndKeepsItsDirection) {
  const GuideLimits limits = GuideLimits::OfForce(0.5);
  const Wrench pull = PullOf({0, 1e6, 0}, {0, 0, -1e300}, limits);
  EXPECT_LT((pull.force - Vec3(0, 0.5, 0)).norm(), 1e-9);
  EXPECT_LT((pull.torque - Vec3(0, 0, -0.005)).norm(), 1e-9);
}

TEST(ServoAim, IsNoneOfWhatIsNotFinite) {
  const GuideLimits limits = GuideLimits::OfForce(0.5);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(ServoAim({}, {Vec3(0, nan, 0), Vec3::Zero()}, limits));
  EXPECT_FALSE(ServoAim({}, {Vec3::Zero(), Vec3(inf, 0, 0)}, limits));
}

TEST(ServoAim, IsForgottenByTheStationATenthOfASecondAfterTheLast) {
  const GuideLimits limits = GuideLimits::OfForce(0.5);
  const Pose X_WH{Vec3::Zero(), Quat::Identity()};
  Guide guide(limits);
  double before = 0.0, greatest_step = 0.0;
  for (std::int64_t tick = 0; tick <= 1100; ++tick) {
    if (tick < 1000) guide.Take(tick * kMs, {1, *ServoAim(X_WH, {Vec3(0.5, 0, 0), {}}, limits)});
    const double now = guide.Pull(tick * kMs, 1e-3, X_WH, {}).force.x();
    greatest_step = std::max(greatest_step, before - now);
    before = now;
  }
  EXPECT_EQ(before, 0.0);
  EXPECT_LE(greatest_step, 0.5 / 50 + 1e-12);  // smoothly: over 50 ms
}

TEST(OperatingState, IsWhatCrtkCallsTheSession) {
  EXPECT_STREQ(CrtkStateOf(palpate_SESSION_ACTIVE, false, 0).state, "ENABLED");
  EXPECT_STREQ(CrtkStateOf(palpate_SESSION_ACTIVE, true, 0).state, "PAUSED");
  EXPECT_STREQ(CrtkStateOf(palpate_SESSION_ACTIVE, false, kFaultBadPose).state, "FAULT");
  EXPECT_STREQ(CrtkStateOf(palpate_SESSION_ACTIVE, false, kFaultJammed).state, "ENABLED");
  EXPECT_TRUE(CrtkStateOf(palpate_SESSION_ACQUIRING, false, 0).busy);
  EXPECT_STREQ(CrtkStateOf(palpate_SESSION_ENDED, false, 0).state, "DISABLED");
  EXPECT_EQ(WishOf("pause", palpate_SESSION_ACTIVE), palpate_OPERATE_MUTE);
  EXPECT_EQ(WishOf("enable", palpate_SESSION_HELD), palpate_OPERATE_ADMIT);
  EXPECT_FALSE(WishOf("home", palpate_SESSION_ACTIVE));
}

TEST(SampleClock, TakesTheFastestWayOfLateAndFollowsAClockThatIsSet) {
  SampleClock clock;
  std::int64_t system_ns = 1'700'000'000'000'000'000, sample_ns = 55;
  for (int i = 0; i < 5000; ++i) {
    const std::int64_t late_ns = i % 10 == 0 ? 30'000 : 900'000;
    clock.Hear(sample_ns, system_ns + late_ns);
    system_ns += kMs;
    sample_ns += kMs;
  }
  EXPECT_NEAR(static_cast<double>(clock.ToSystem(sample_ns) - system_ns), 30'000.0, 2'000.0);
  system_ns += 3600 * 1000 * kMs;  // set forward by an hour
  clock.Hear(sample_ns, system_ns);
  EXPECT_EQ(clock.ToSystem(sample_ns), system_ns);
}

}  // namespace
}  // namespace palpate::test
