#include "server/physics/tree/leaf_wear.h"

#include <cmath>
#include <cstring>
#include <utility>

#include <gtest/gtest.h>

#include "common/error.h"
#include "common/math/rotation.h"
#include "server/physics/start_pose.h"
#include "tests/support/step_bench.h"

namespace palpate {
namespace {

using test::AllOf;
using test::At;
using test::Ball;
using test::Bench;
using test::Floor;

StepParameters Removing() {
  StepParameters parameters;
  parameters.features.removal = true;
  return parameters;
}

/// Rows of balls that wear, beside and on a floor of balls that do not.
Bench Calculus(double hardness) {
  std::vector<Ball> balls = Floor(0.02, 0.002, 0.002);
  for (const Ball& ball : Floor(0.008, 0.001, 0.001)) {
    balls.push_back({ball.center + Vec3(0.0, 0.0, 0.0015), ball.radius});
  }
  return Bench(
      {{Vec3(0.0, 0.0, 0.0), 0.003}, {Vec3(0.0, 0.004, 0.001), 0.003}}, balls, Removing(),
      {{Material{}, Material{.hardness = hardness}}, [](const Vec3& c) { return c.z() > -0.001; }});
}

/// Back and forth over it, pressed.
Pose Stroke(int i) {
  Pose X = At(0.007 * std::sin(4e-3 * i), 0.006 * std::sin(1.1e-3 * i), 0.0015);
  X.q = RotationExp(Vec3(0.1 * std::sin(3e-3 * i), 0.0, 0.0));
  return X;
}

TEST(LeafWear, TakesNothingFromAStateThatWasMadeWithoutItsModel) {
  Bench bench({{Vec3::Zero(), 0.005}}, {{Vec3(0.0, 0.0, -1e4), 1e4}}, Removing(),
              AllOf({.hardness = 1e-9}));
  bench.state() = StepState();
  bench.state().X_WG = At(0.0, 0.0, 0.0051);
  for (int i = 1; i <= 20; ++i) {
    const StepReport report = bench.Step(At(1e-4 * i, 0.0, 0.004));
    EXPECT_GT(report.contacts, 0);
    EXPECT_EQ(report.removals, 0);
  }
}

TEST(LeafWear, TakesALeafAwayOnceItsHardnessIsSpent) {
  Bench bench({{Vec3::Zero(), 0.005}}, {{Vec3(0.0, 0.0, -1e4), 1e4}}, Removing(),
              AllOf({.hardness = 0.005}));
  bench.state().X_WG = At(0.0, 0.0, 0.0051);
  bench.Repeat(At(0.0, 0.0, 0.004), 20);
  int removals = 0, at = 0;
  for (int i = 1; i <= 100; ++i) {
    const StepReport report = bench.Step(At(1e-4 * i, 0.0, 0.004));
    if (removals > 0) {
      EXPECT_EQ(report.contacts, 0) << i;
      EXPECT_EQ(report.wrench.force, Vec3::Zero());
    }
    if (report.removals > 0) {
      EXPECT_EQ(report.removed[0], 0);
      at = i;
    }
    removals += report.removals;
  }
  EXPECT_EQ(removals, 1);
  EXPECT_NEAR(at, 50, 1);  // 5 mJ at 1 N: 5 mm
  EXPECT_TRUE(bench.state().wear.gone(0));
  EXPECT_EQ(bench.state().wear.gone_count(), 1);
  EXPECT_EQ(
      ResolveStart(bench.model(), At(0.0, 0.0, 0.0), bench.workspace(), &bench.state().wear).depth,
      0.0);
}

TEST(LeafWear, ReplaysToTheSameBitsFromACopyOfTheState) {
  Bench bench = Calculus(2e-3);
  bench.state().X_WG = At(0.0, 0.0, 0.01);
  std::vector<StepReport> first;
  StepState copy;
  constexpr int kSteps = 6000, kCopied = 2500;
  int removals = 0, before_copy = 0;
  for (int i = 0; i < kSteps; ++i) {
    if (i == kCopied) {
      copy = bench.state();
      before_copy = removals;
    }
    first.push_back(bench.Step(Stroke(i)));
    removals += first.back().removals;
  }
  EXPECT_GT(before_copy, 5);
  EXPECT_GT(removals - before_copy, 5);
  const LeafWear worn = bench.state().wear;
  bench.state() = copy;
  for (int i = kCopied; i < kSteps; ++i) {
    const StepReport again = bench.Step(Stroke(i));
    const StepReport& then = first[static_cast<std::size_t>(i)];
    ASSERT_EQ(std::memcmp(&again.wrench, &then.wrench, sizeof again.wrench), 0) << i;
    ASSERT_EQ(again.X_WG.p, then.X_WG.p) << i;
    ASSERT_EQ(again.removals, then.removals) << i;
    for (std::size_t k = 0; k < static_cast<std::size_t>(again.removals); ++k) {
      EXPECT_EQ(again.removed[k], then.removed[k]);
    }
  }
  EXPECT_TRUE(bench.state().wear == worn);
}

TEST(LeafWear, StandsWhereTheReportedEventsSay) {
  Bench bench = Calculus(2e-3);
  bench.state().X_WG = At(0.0, 0.0, 0.01);
  LeafWear told(bench.model().objects());
  for (int i = 0; i < 4000; ++i) {
    const StepReport report = bench.Step(Stroke(i));
    for (int k = 0; k < report.removals; ++k) {
      EXPECT_TRUE(told.Remove(report.removed[static_cast<std::size_t>(k)]));
    }
    for (int k = 0; k < report.contacts; ++k) {
      const int leaf = report.active[static_cast<std::size_t>(k)].object_leaf;
      bool just_now = false;
      for (int r = 0; r < report.removals; ++r) {
        just_now |= report.removed[static_cast<std::size_t>(r)] == leaf;
      }
      EXPECT_TRUE(just_now || !told.gone(leaf));
    }
  }
  EXPECT_GT(told.gone_count(), 10);
  for (int leaf = 0; leaf < bench.model().objects().leaf_count(); ++leaf) {
    EXPECT_EQ(told.gone(leaf), bench.state().wear.gone(leaf));
    if (bench.model().objects().MaterialOf(leaf).hardness > 1.0) {
      EXPECT_FALSE(told.gone(leaf));
    }
  }
}

TEST(LeafWear, IsNoneWhereRemovalIsNotDeclared) {
  Bench bench({{Vec3::Zero(), 0.005}}, {{Vec3(0.0, 0.0, -1e4), 1e4}}, {},
              AllOf({.hardness = 1e-6}));
  bench.state().X_WG = At(0.0, 0.0, 0.0051);
  for (int i = 1; i <= 100; ++i) {
    const StepReport report = bench.Step(At(1e-4 * i, 0.0, 0.004));
    EXPECT_EQ(report.removals, 0);
    EXPECT_EQ(report.contacts, 1);
  }
  EXPECT_TRUE(bench.state().wear == LeafWear());
}

TEST(LeafWear, KeepsPairsInTheirOrder) {
  Bench bench = Calculus(1.0);
  LeafWear wear(bench.model().objects());
  std::vector<NodePair> pairs{{0, 5}, {1, 3}, {0, 64}, {1, 5}, {0, 65}};
  EXPECT_EQ(wear.KeepPresent(pairs.data(), 5), 5);
  EXPECT_TRUE(wear.Remove(5));
  EXPECT_TRUE(wear.Remove(64));
  EXPECT_FALSE(wear.Remove(64));
  ASSERT_EQ(wear.KeepPresent(pairs.data(), 5), 2);
  EXPECT_EQ(pairs[0], (NodePair{1, 3}));
  EXPECT_EQ(pairs[1], (NodePair{0, 65}));
}

TEST(LeafWear, RefusesAHardnessThatIsNotPositive) {
  EXPECT_THROW(
      Bench({{Vec3::Zero(), 0.005}}, {{Vec3::Zero(), 0.01}}, Removing(), AllOf({.hardness = 0.0})),
      Error);
}

}  // namespace
}  // namespace palpate
