#include "scenes/tree/leaf_count.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/scene.h"
#include "scenes/shapes/shapes.h"
#include "scenes/tree/sphere_tree_builder.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

using testing::HasSubstr;

TEST(LeafCount, IsTheLeastThatIsEnoughWithinATenth) {
  for (const double power : {0.5, 1.0, 2.0}) {
    for (const double least : {65.0, 90.0, 100.0, 1000.0, 5000.0, 16000.0}) {
      const auto error = [&](std::size_t n) { return std::pow(double(n), -power); };
      const LeafCount chosen = ChooseLeafCount(std::pow(least, -power), kMostByTolerance, error);
      EXPECT_TRUE(chosen.reached);
      EXPECT_GE(double(chosen.count), least * (1.0 - 1e-9));
      EXPECT_LE(double(chosen.count), least * 1.1);
      EXPECT_EQ(chosen.error, error(chosen.count));
      EXPECT_LE(chosen.tried, 12);  // 64 to 16,384, and three in between
    }
  }
}

TEST(LeafCount, StopsAtTheMostAndSaysSo) {
  for (const std::size_t most : {1u, 63u, 64u, 100u, 16384u}) {
    std::set<std::size_t> asked;
    const LeafCount chosen = ChooseLeafCount(1e-3, most, [&](std::size_t n) {
      EXPECT_LE(n, most);
      EXPECT_TRUE(asked.insert(n).second) << n;
      return 1.0;
    });
    EXPECT_FALSE(chosen.reached);
    EXPECT_EQ(chosen.count, most);
    EXPECT_EQ(chosen.error, 1.0);
  }
}

TEST(LeafCount, NeverFallsWhereTheToleranceIsTighter) {
  test::Random random(5);
  for (int shape = 0; shape < 200; ++shape) {
    // Errors that fall overall, with arbitrary ups and downs.
    std::vector<double> noise(kMostByTolerance + 1);
    for (double& n : noise) n = random.Uniform(0.3, 3.0);
    const auto error = [&](std::size_t n) { return noise[n] / double(n); };
    std::size_t before = 0;
    for (double tolerance = 0.1; tolerance > 1e-5; tolerance *= 0.7) {
      const LeafCount chosen = ChooseLeafCount(tolerance, kMostByTolerance, error);
      EXPECT_GE(chosen.count, before) << shape << " " << tolerance;
      EXPECT_EQ(chosen.reached, error(chosen.count) <= tolerance);
      before = chosen.count;
    }
  }
}

TEST(LeafCount, TellsHowMuchIsDoneWithoutEverGoingBack) {
  for (const double power : {0.1, 0.5, 3.0}) {
    double before = 0.0;
    int told = 0;
    const LeafCount chosen = ChooseLeafCount(
        std::pow(3000.0, -power), kMostByTolerance,
        [&](std::size_t n) { return std::pow(double(n), -power); },
        [&](std::size_t, double from, double to) {
          EXPECT_GE(from, before);
          EXPECT_GE(to, from);
          EXPECT_LE(to, 1.0);
          before = to;
          ++told;
        });
    EXPECT_EQ(told, chosen.tried);
    EXPECT_GT(before, 0.9);
  }
}

/// Height of the union of balls over a point along its normal, over all balls.
double HeightByAllBalls(const SphereTree& tree, const Vec3& p, const Vec3& n) {
  std::vector<std::pair<double, double>> inside;  // from, to, along the normal
  for (std::size_t i = 0; i < tree.leaves(); ++i) {
    const Vec3 to = Vec3(tree.leaf_x[i], tree.leaf_y[i], tree.leaf_z[i]) - p;
    const double middle = to.dot(n);
    const double half2 = std::pow(tree.leaf_radius[i], 2) - (to - middle * n).squaredNorm();
    if (half2 > 0.0) inside.push_back({middle - std::sqrt(half2), middle + std::sqrt(half2)});
  }
  std::sort(inside.begin(), inside.end());
  // Up from the point as long as balls overlap, or else down to the first ball.
  double height = 0.0;
  for (const auto& [from, to] : inside) {
    if (from <= height && to > height) height = to;
  }
  if (height > 0.0) return height;
  height = -1.0;  // nothing on the normal
  for (const auto& [from, to] : inside) height = std::max(height, to);
  return height;
}

TEST(LeafCount, HoldsTheToleranceOnAnEllipsoidOfItsFormula) {
  const Vec3 axes(0.04, 0.025, 0.03);
  const TriangleMesh mesh = MakeEllipsoid(axes, 5120);
  constexpr double kTolerance = 150e-6;
  const TolerantTree built = BuildToTolerance(mesh, {.most = kTolerance});
  EXPECT_TRUE(built.chosen.reached) << built.found;
  EXPECT_GT(built.tree.leaves(), kFewestByTolerance);
  EXPECT_LT(built.tree.leaves(), 500u);
  // At points of the true surface; the mesh lies up to 30 um below it.
  test::Random random(3);
  int off = 0;
  constexpr int kPoints = 2000;
  for (int i = 0; i < kPoints; ++i) {
    const Vec3 d = random.Direction();
    const Vec3 n = d.cwiseQuotient(axes).normalized();
    const double height = HeightByAllBalls(built.tree, d.cwiseProduct(axes), n);
    off += std::abs(height) > kTolerance + 30e-6;
  }
  EXPECT_LT(off, kPoints / 20);
}

TEST(LeafCount, MakesTheTreeThatItsCountMakes) {
  const TriangleMesh mesh = MakeBox(Vec3(0.05, 0.04, 0.03));
  const TolerantTree built =
      BuildToTolerance(mesh, {.of = LeafTolerance::Of::kLean, .most = 25.0 * M_PI / 180.0});
  EXPECT_TRUE(built.chosen.reached) << built.found;
  EXPECT_THAT(built.found, HasSubstr(" leaves for 25 degrees: "));
  EXPECT_EQ(built.shortfall, "");
  const SphereTree again = BuildSphereTree(mesh, built.chosen.count);
  EXPECT_EQ(built.tree.leaf_x, again.leaf_x);
  EXPECT_EQ(built.tree.leaf_radius, again.leaf_radius);
  EXPECT_EQ(built.tree.leaf_triangle, again.leaf_triangle);
  EXPECT_EQ(built.tree.level_begin, again.level_begin);
  EXPECT_EQ(built.tree.origin, TreeOrigin::kInside);
}

TEST(LeafCount, KeepsTheTruestTreeWhereTheToleranceIsOutOfReach) {
  const TriangleMesh mesh = MakeBox(Vec3(0.05, 0.04, 0.03));
  const TolerantTree built = BuildToTolerance(mesh, {.most = 1e-6, .most_leaves = 100});
  EXPECT_FALSE(built.chosen.reached);
  EXPECT_EQ(built.tree.leaves(), 100u);
  EXPECT_THAT(built.shortfall, HasSubstr("is not reached: 100 leaves for 1 um: "));
  EXPECT_THAT(built.shortfall, HasSubstr("raise tolerance_um or most_leaves"));
}

TEST(LeafCount, IsToldWithItsErrorAndUnit) {
  EXPECT_EQ(ToText({.count = 1240, .error = 94e-6, .reached = true, .tried = 9}, {}, 100e-6),
            "1,240 leaves for 100 um: 94 um off at 95 of 100 places (9 counts tried)");
  EXPECT_EQ(ToText({.count = 64, .error = 0.05, .reached = true, .tried = 1},
                   {.of = LeafTolerance::Of::kLean}, M_PI / 36.0),
            "64 leaves for 5 degrees: 2.86 degrees off on average (1 counts tried)");
}

}  // namespace
}  // namespace palpate
