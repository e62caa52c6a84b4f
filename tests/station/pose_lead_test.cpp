#include "client/station/pose_lead.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

constexpr std::int64_t kMs = 1'000'000;

/// A lead that has heard of that round trip for long.
PoseLead After(double round_trip_s) {
  PoseLead lead;
  for (int i = 0; i < 1000; ++i) lead.Hear(round_trip_s);
  return lead;
}

/// The last of `poses` that move on at a steady pace, as led.
Pose AtSteadyPace(PoseLead lead, const Vec3& v, const Vec3& w, int poses = 20) {
  Pose led;
  for (int i = 0; i < poses; ++i) {
    led = lead.Lead(i * kMs, {1e-3 * i * v, RotationExp(1e-3 * i * w)});
  }
  return led;
}

TEST(PoseLead, IsNoneForAServerOnThisHost) {
  const Vec3 v(0.1, 0.2, 0.0);
  EXPECT_EQ(AtSteadyPace(After(0.5e-3), v, Vec3::Zero()).p, 0.019 * v);
  EXPECT_EQ(AtSteadyPace(After(PoseLead::kNear_s), v, Vec3::Zero()).p, 0.019 * v);
  EXPECT_EQ(AtSteadyPace(PoseLead(), v, Vec3::Zero()).p, 0.019 * v) << "nothing is known of it";
}

TEST(PoseLead, IsWhereASteadyHandIsWhenTheReplyIsHeldAndBlendedIn) {
  const Vec3 v(0.1, -0.05, 0.02), w(0.3, 0.2, -0.5);
  const Pose led = AtSteadyPace(After(0.010), v, w);
  const double then_s = 0.019 + 0.010 + PoseLead::kHeld_s;
  EXPECT_LT((led.p - then_s * v).norm(), 1e-9);
  EXPECT_LT(RotationLog(led.q * RotationExp(then_s * w).conjugate()).norm(), 1e-9);
}

TEST(PoseLead, GrowsWithTheRoundTripWithoutAJump) {
  double last = 0.0;
  for (double round_trip = 0.0; round_trip < 0.040; round_trip += 1e-5) {
    const double lead = After(round_trip).lead_s();
    EXPECT_GE(lead, last);
    EXPECT_LE(lead - last, 5e-5);
    EXPECT_LE(lead, PoseLead::kMost_s + PoseLead::kHeld_s);
    last = lead;
  }
  EXPECT_NEAR(last, PoseLead::kMost_s + PoseLead::kHeld_s, 1e-9);
}

TEST(PoseLead, NeverGoesFarHoweverFastTheHandIs) {
  const Pose led = AtSteadyPace(After(0.020), Vec3(2, 0, 0), Vec3(0, 20, 0));
  EXPECT_NEAR(led.p.x() - 2 * 0.019, PoseLead::kMost_m, 1e-12);
  EXPECT_NEAR(RotationLog(led.q * RotationExp(Vec3(0, 20 * 0.019, 0)).conjugate()).norm(),
              PoseLead::kMost_rad, 1e-12);
}

TEST(PoseLead, HasNoneUntilTheVelocityIsKnownAndAnewAfterAnotherSession) {
  const Vec3 v(0.1, 0, 0);
  EXPECT_EQ(AtSteadyPace(After(0.010), v, Vec3::Zero(), PoseLead::kWindow).p,
            1e-3 * (PoseLead::kWindow - 1) * v);
  PoseLead lead = After(0.010);
  for (int i = 0; i < 20; ++i) lead.Lead(i * kMs, {1e-3 * i * v, Quat::Identity()});
  lead.Forget();
  EXPECT_EQ(lead.Lead(20 * kMs, {v, Quat::Identity()}).p, v) << "the tool of another scene";
}

/// A hand at rest whose encoders tremble by a step is led by no more than the lead makes of it.
TEST(PoseLead, MagnifiesAnEncodersStepByNoMoreThanLeadOverWindow) {
  const double step = 20e-6;
  PoseLead lead = After(0.010);
  const double most = lead.lead_s() / (1e-3 * PoseLead::kWindow);
  test::Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const Pose X{Vec3(random.Below(2) * step, 0, 0), Quat::Identity()};
    EXPECT_LE((lead.Lead(i * kMs, X).p - X.p).norm(), most * step + 1e-15);
  }
}

TEST(PoseLead, LeavesWhatIsNoNumberToTheServerAndForgetsIt) {
  PoseLead lead = After(0.010);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < 20; ++i) lead.Lead(i * kMs, {Vec3::Constant(nan), Quat::Identity()});
  EXPECT_TRUE(std::isnan(lead.Lead(20 * kMs, {Vec3::Constant(nan), Quat::Identity()}).p.x()));
  Pose led;
  for (int i = 21; i < 21 + PoseLead::kWindow + 1; ++i) led = lead.Lead(i * kMs, Pose());
  EXPECT_TRUE(led.p.isZero());
  lead.Hear(nan);
  EXPECT_TRUE(std::isfinite(lead.lead_s()));
}

}  // namespace
}  // namespace palpate
