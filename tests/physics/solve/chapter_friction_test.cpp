#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "server/physics/solve/stages.h"
#include "tests/physics/solve/friction_bench.h"

namespace palpate {
namespace {

using namespace test;

class ChapterFriction : public FrictionTool {};
INSTANTIATE_TEST_SUITE_P(BallAndBox, ChapterFriction, testing::Bool(),
                         [](const auto& which) { return which.param ? "Box" : "Ball"; });

TEST_P(ChapterFriction, HoldsTheToolUntilTheHandIsFarAheadAndThenLetsItGo) {
  // Eq. 2.34 holds the tool until the hand is ahead by mu_s times its depth, then lets the tool
  // catch up, with mu_d times the normal force (2.29), and holds it again: a sawtooth.
  Bench bench(tool(), kPlane, Rubbing(FrictionModel::kChapter), Rough(0.8, 0.3));
  bench.state().X_WG = At(0.0, 0.0, rest());
  double most = 0.0, sum = 0.0;
  int steps = 0, releases = 0, longest = 0, resets = 0;
  Vec3 before(0.0, 0.0, rest());
  for (int i = 0; i < 4000; ++i) {
    const Vec3 hand(2e-6 * i, 0.0, rest() - 1e-3);
    const StepReport report = bench.Step({hand, Quat::Identity()});
    const double ratio = Ratio(report, Vec3::UnitZ());
    if (report.diagnostics.friction_resets > 0) {
      ASSERT_EQ(report.X_WG.p, before);
      ASSERT_EQ(report.diagnostics.friction_resets, resets + 1);
      ASSERT_NEAR(ratio, 1e3 * (hand.x() - before.x()), 1e-4);
    } else if (i > 0) {
      ++releases;
      ASSERT_NEAR(ratio, 0.3, 3e-3);
      ASSERT_NEAR(report.X_WG.p.x(), hand.x(), 1e-6);
    }
    Vec3 force = Vec3::Zero();
    for (int c = 0; c < report.contacts; ++c) {
      const ActiveRow& row = report.active[static_cast<std::size_t>(c)];
      force += row.force * row.normal + row.friction;
    }
    ASSERT_LT((force - report.wrench.force).norm(), 1e-6);
    resets = report.diagnostics.friction_resets;
    before = report.X_WG.p;
    longest = std::max(longest, report.diagnostics.friction_resets);
    most = std::max(most, ratio);
    sum += ratio;
    ++steps;
  }
  EXPECT_NEAR(releases, 8.0 / 0.8, 1.0);  // 8 mm of path, one release every 0.8 mm
  EXPECT_NEAR(longest, 400, 2);
  EXPECT_NEAR(most, 0.8, 3e-3);
  EXPECT_NEAR(sum / steps, 0.4, 0.01);  // the mean of the sawtooth: neither mu_s nor mu_d
}

TEST(ChapterFrictionOfABox, ResistsSpinByTheRotationRule) {
  // About its own centre the equivalent contact point does not move; the rotation rule applies.
  Bench bench(BoxTool(), kPlane, Rubbing(FrictionModel::kChapter), Rough(0.8, 0.3));
  bench.state().X_WG = At(0.0, 0.0, 0.01);
  const double radius = 0.02 * std::sqrt(2.0);
  double most = 0.0;
  int releases = 0;
  for (int i = 0; i < 4000; ++i) {
    Pose X = At(0.0, 0.0, 0.01 - 1e-3);
    X.q = RotationExp(Vec3(0.0, 0.0, 5e-5 * i));
    const StepReport report = bench.Step(X);
    most = std::max(most, -report.wrench.torque.z());
    releases += i > 0 && report.diagnostics.friction_resets == 0;
  }
  EXPECT_NEAR(most, 0.8 * 1e-3 / radius, 1e-4);  // r theta = mu_s depth, times k_r = 1 N m/rad
  EXPECT_GE(releases, 6);
  EXPECT_LE(releases, 8);
}

TEST(ChapterFrictionAmongBalls, AllocatesNothing) {
  ExpectNoAllocation(FrictionModel::kChapter);
}

}  // namespace
}  // namespace palpate
