#include "scenes/tree/tree_error.h"

#include <algorithm>
#include <cmath>

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
    const UnionError error = MeasureUnion(mesh, {{Vec3::Zero(), radius}}, 5003);
    // The mesh lies up to 10 um below its sphere, and its facets lean by 0.024 rad at most.
    EXPECT_NEAR(error.offset.mean, radius - 0.03, 12e-6);
    EXPECT_NEAR(error.offset.max, error.offset.min, 30e-6);
    EXPECT_LT(error.tilt.max, 0.025);
    EXPECT_EQ(error.missed_share, 0.0);
    EXPECT_EQ(error.uncovered_share, radius < 0.03 ? 1.0 : 0.0);
    EXPECT_NEAR(error.volume_ratio, std::pow(radius / 0.03, 3), 0.03);
    EXPECT_NEAR(error.protrusion.max, std::max(0.0, radius - 0.03), 12e-6);
  }
}

TEST(TreeError, FollowsTheNormalOfABoxIntoTheBallWithin) {
  // Over a face, at (x, y) from its middle: the height sqrt(r^2 - x^2 - y^2) - h below the face,
  // and the tilt asin(sqrt(x^2 + y^2) / r); outside the ball's shadow there is nothing.
  const UnionError error = MeasureUnion(MakeBox(Vec3(2, 2, 2)), {{Vec3::Zero(), 1.0}}, 40009);
  EXPECT_NEAR(error.missed_share, 1.0 - M_PI / 4.0, 0.01);
  EXPECT_NEAR(error.offset.mean, -1.0 / 3.0, 0.01);  // of 1 - sqrt(1 - q^2) over the disc
  EXPECT_NEAR(error.tilt.mean, M_PI / 4.0, 0.01);
  EXPECT_NEAR(error.volume_ratio, M_PI / 6.0, 0.01);
  EXPECT_GE(error.uncovered_share, 0.99);
}

TEST(TreeError, FollowsTheUnionThroughBallsThatOverlap) {
  // On a side of the rod, at the height of the large ball's middle, 0.01 from its axis.
  const std::vector<Sphere> balls{{Vec3(0, 0, 0.5), 0.2}, {Vec3(0, 0, 0.3), 0.6}};
  const UnionError error = MeasureUnion(MakeBox(Vec3(0.02, 0.02, 1)), balls, 20011);
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
    // Bounds of leaves that touch the surface stick out of it.
    EXPECT_GT(error.levels[l].protrusion.max, 1e-3);
  }
  EXPECT_THAT(ToText(error), HasSubstr("3, leaves"));
  EXPECT_THAT(ToText(error), HasSubstr("1, bounds"));
  const std::string csv = ToCsv(error, "inside", true);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 4);
  EXPECT_THAT(csv, HasSubstr("box,inside,3,leaves,100,"));
  EXPECT_THAT(ToJsonText(error), HasSubstr("\"kind\":\"leaves\",\"spheres\":100"));
}

}  // namespace
}  // namespace palpate
