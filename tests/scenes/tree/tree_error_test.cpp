#include "scenes/tree/tree_error.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/shapes/shapes.h"
#include "scenes/tree/sphere_tree_builder.h"
#include "scenes/tree/tree_error_table.h"

namespace palpate {
namespace {

using testing::HasSubstr;

TEST(TreeError, FindsABallAsHighAsItIsOverItsMesh) {
  const TriangleMesh mesh = MakeSphere(0.03, 20480);
  for (const double radius : {0.029, 0.0305}) {
    const UnionError error = SurfaceGauge(mesh, 5003).Measure({{Vec3::Zero(), radius}});
    // The mesh lies up to 10 um below its sphere, and its facets tilt by at most 0.024 rad.
    EXPECT_NEAR(error.offset.mean, radius - 0.03, 12e-6);
    EXPECT_NEAR(error.offset.max, error.offset.min, 30e-6);
    EXPECT_LT(error.tilt.max, 0.025);
    EXPECT_EQ(error.missed_share, 0.0);
    EXPECT_EQ(error.uncovered_share, radius < 0.03 ? 1.0 : 0.0);
    EXPECT_NEAR(error.volume_ratio, std::pow(radius / 0.03, 3), 0.03);
    EXPECT_NEAR(error.protrusion.max, std::max(0.0, radius - 0.03), 12e-6);
    EXPECT_NEAR(error.off_p95, std::abs(radius - 0.03), 12e-6);
    EXPECT_NEAR(error.mean_lean, error.tilt.mean, 1e-12);
  }
}

TEST(TreeError, FollowsTheNormalOfABoxIntoTheBallWithin) {
  // Over a face, at (x, y) from its centre: the height is sqrt(r^2 - x^2 - y^2) - h, below the
  // face, and the tilt asin(sqrt(x^2 + y^2) / r); outside the ball's shadow there is nothing.
  const UnionError error =
      SurfaceGauge(MakeBox(Vec3(2, 2, 2)), 40009).Measure({{Vec3::Zero(), 1.0}});
  EXPECT_NEAR(error.missed_share, 1.0 - M_PI / 4.0, 0.01);
  EXPECT_NEAR(error.offset.mean, -1.0 / 3.0, 0.01);  // mean of 1 - sqrt(1 - q^2) over the disc
  EXPECT_NEAR(error.tilt.mean, M_PI / 4.0, 0.01);
  EXPECT_NEAR(error.volume_ratio, M_PI / 6.0, 0.01);
  EXPECT_GE(error.uncovered_share, 0.99);
  // Points whose normal misses the ball count with a right angle, and with their distance to it.
  const double shadow = M_PI / 4.0;
  EXPECT_NEAR(error.mean_lean, shadow * error.tilt.mean + (1.0 - shadow) * M_PI / 2.0, 0.01);
  // In the shadow a share (1 - x)^2 is off by more than x; beside it at most sqrt(3) - 1 = 0.73.
  EXPECT_NEAR(error.off_p95, 1.0 - std::sqrt(0.05 / shadow), 0.01);
}

TEST(TreeError, TellsAtPointsWhatItTellsOfTheWhole) {
  const TriangleMesh mesh = MakeBox(Vec3(2, 2, 2));
  SurfaceSample up, edge;
  up.point = Vec3(0.3, 0.4, 1.0);
  edge.point = Vec3(0.9, 0.9, 1.0);
  up.outward = edge.outward = Vec3::UnitZ();
  const std::vector<double> at = OffsetsAt({up, edge}, SphereQuery({{Vec3::Zero(), 1.0}}), 4.0);
  EXPECT_NEAR(at[0], std::sqrt(0.75) - 1.0, 1e-8);
  EXPECT_TRUE(std::isnan(at[1]));
}

TEST(TreeError, IsATableOfOneUnitThatFitsATerminal) {
  BodyTreeError error{"b", std::vector<UnionError>(2)};
  error.levels[0].spheres = 1048576;
  error.levels[0].uncovered_share = error.levels[0].volume_ratio = 1.0;
  for (const double longest : {0.0099, 0.0999, 0.999, 99.0}) {
    error.levels[0].offset.min = error.levels[0].offset.mean = -longest;
    const std::string text = ToText(error);
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 109u) << line;
    // No two numbers run into each other.
    EXPECT_THAT(text, testing::Not(testing::ContainsRegex("[0-9]-[0-9]"))) << text;
  }
  EXPECT_STREQ(UnitOf({error}).name, "m");
  EXPECT_THAT(AboutLevelTable(), HasSubstr("levels 1 to N-1 bound the leaves below them"));
}

TEST(TreeError, FollowsTheUnionThroughBallsThatOverlap) {
  // On a side of the rod, at the height of the large ball's centre, 0.01 from its axis.
  const std::vector<Sphere> balls{{Vec3(0, 0, 0.5), 0.2}, {Vec3(0, 0, 0.3), 0.6}};
  const UnionError error = SurfaceGauge(MakeBox(Vec3(0.02, 0.02, 1)), 20011).Measure(balls);
  EXPECT_NEAR(error.offset.max, 0.59, 1e-4);
  EXPECT_GT(error.protrusion.max, 0.39);
}

TEST(TreeError, MeasuresEveryLevelAndSaysWhatItIs) {
  Body body;
  body.mesh = MakeBox(Vec3(0.05, 0.05, 0.05));
  body.tree = BuildSphereTree(body.mesh, 100);
  const BodyTreeError error{"box", MeasureLevels(body.mesh, body.tree, 5003)};
  ASSERT_EQ(error.levels.size(), 3u);
  EXPECT_EQ(error.levels.back().spheres, 100u);
  EXPECT_EQ(error.levels.back().protrusion.max < 1e-9, true);
  for (std::size_t l = 0; l + 1 < error.levels.size(); ++l) {
    // Bounding balls of leaves that touch the surface stick out of it.
    EXPECT_GT(error.levels[l].protrusion.max, 1e-3);
  }
  EXPECT_THAT(ToText(error), HasSubstr("3, leaves"));
  EXPECT_THAT(ToText(error), HasSubstr("1, bounds"));
  EXPECT_THAT(ToJsonText(error), HasSubstr("\"kind\":\"leaves\",\"spheres\":100"));
}

TEST(Coverage, OfABallInACubeIsKnown) {
  // The ball touches the centres of the faces; the cube's corners are farthest, at sqrt(3)/2.
  const TriangleMesh cube = MakeBox(Vec3(1, 1, 1));
  const Coverage c = MeasureCoverage(cube, SingleSphereTree(cube, {Vec3::Zero(), 0.5}), 50000);
  EXPECT_EQ(c.outside.max, 0.0);
  EXPECT_NEAR(c.uncovered.max, 0.8660 - 0.5, 0.01);
  // Mean distance from the centre to a unit square half a unit away: 0.64030, numerically.
  EXPECT_NEAR(c.uncovered.mean, 0.6403 - 0.5, 0.001);
  EXPECT_LT(c.uncovered.p99, c.uncovered.max);
}

TEST(Coverage, SeesABallThatSticksOut) {
  const TriangleMesh cube = MakeBox(Vec3(1, 1, 1));
  EXPECT_NEAR(
      MeasureCoverage(cube, SingleSphereTree(cube, {Vec3(0.3, 0, 0), 0.4}), 100).outside.max, 0.2,
      1e-12);
  EXPECT_NEAR(MeasureCoverage(cube, SingleSphereTree(cube, {Vec3(2, 0, 0), 0.4}), 100).outside.max,
              1.9, 1e-12);
}

}  // namespace
}  // namespace palpate
