#include "scenes/tree/coverage.h"

#include <gtest/gtest.h>

#include "scenes/tree/sphere_tree_builder.h"
#include "tests/scenes/support.h"

namespace palpate {
namespace {

TEST(Coverage, OfABallInACubeIsKnown) {
  // The ball touches the faces' middles; the corners of the cube are furthest, at sqrt(3)/2.
  const TriangleMesh cube = MakeBox(Vec3(1, 1, 1));
  const Coverage c = MeasureCoverage(cube, SingleSphereTree(cube, {Vec3::Zero(), 0.5}), 50000);
  EXPECT_EQ(c.outside.max, 0.0);
  EXPECT_NEAR(c.uncovered.max, 0.8660 - 0.5, 0.01);
  // Mean distance of a unit square's points, half a unit below, from the centre: 0.64030 (by
  // numerical integration).
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
