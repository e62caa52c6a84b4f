#include "scenes/tree/inner_balls.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/scenes/support.h"

namespace palpate {
namespace {

struct Solid {
  Solid(TriangleMesh m, double spacing)
      : mesh(std::move(m)), report(InspectMesh(mesh)), query(mesh), inner(report, query, spacing) {}
  TriangleMesh mesh;
  MeshReport report;
  MeshQuery query;
  InnerBalls inner;
};

SurfaceSample TopOfCube(double x, double z) {
  return {Vec3(x, 0.5, z), Vec3::UnitY(), 0};
}

/// Assigns a sample to its nearest triangle.
SurfaceSample On(const Solid& solid, SurfaceSample s) {
  s.triangle = solid.query.Nearest(s.point).triangle;
  return s;
}

TEST(InnerBalls, TouchesACubesFaceAsFarAsItsSidesAllow) {
  const Solid cube(MakeBox(Vec3(1, 1, 1)), 0.2);
  // As large as the distance to the nearest edge, apart from the small extra depth that is allowed.
  Sphere ball = cube.inner.Tangent(On(cube, TopOfCube(0.01, 0.02)));
  EXPECT_NEAR(ball.radius, 0.48, 0.006);
  EXPECT_NEAR(ball.centre.y() + ball.radius, 0.5, 0.001);
  ball = cube.inner.Tangent(On(cube, TopOfCube(0.3, 0.1)));
  EXPECT_NEAR(ball.radius, 0.2, 0.012);
  EXPECT_NEAR(ball.centre.y() + ball.radius, 0.5, 0.007);
}

TEST(InnerBalls, IsNeverLargerThanFiveSpacingsWhereItTouches) {
  const Solid cube(MakeBox(Vec3(1, 1, 1)), 0.02);
  EXPECT_NEAR(cube.inner.Tangent(On(cube, TopOfCube(0.1, 0.1))).radius, 0.1, 1e-12);
}

TEST(InnerBalls, LiesInsideWhereverItTouchesAnEllipsoid) {
  const Solid solid(MakeEllipsoid(Vec3(0.04, 0.025, 0.03), 1280), 0.004);
  for (const SurfaceSample& s : ScatterSamples(solid.mesh, solid.report, solid.query, 300)) {
    const Sphere ball = solid.inner.Tangent(s);
    EXPECT_TRUE(solid.query.Inside(ball.centre));
    EXPECT_LE(ball.radius, solid.query.Nearest(ball.centre).distance * (1 + 1e-12));
    EXPECT_GT(ball.radius, 0.003);
    // It may lie deeper than touching by 3 % of the spacing.
    EXPECT_LT((ball.centre - s.point).norm() - ball.radius, 0.03 * 0.004 * 1.05);
  }
}

TEST(InnerBalls, GivesNoneWhereTheSampleFacesTheWrongWay) {
  const Solid cube(MakeBox(Vec3(1, 1, 1)), 0.2);
  SurfaceSample s = On(cube, TopOfCube(0.1, 0.1));
  s.outward = -s.outward;
  EXPECT_EQ(cube.inner.Tangent(s).radius, 0.0);
}

TEST(InnerBalls, FillsABoxUntilNoPointWellInsideIsBare) {
  const Solid box(MakeBox(Vec3(1, 1, 3)), 0.2);
  const auto fill = box.inner.Fill({}, 100);
  ASSERT_GE(fill.size(), 3u);
  EXPECT_NEAR(fill[0].radius, 0.5, 0.01);
  for (const Sphere& ball : fill) {
    EXPECT_TRUE(box.query.Inside(ball.centre));
    EXPECT_LE(ball.radius, box.query.Nearest(ball.centre).distance * (1 + 1e-12));
  }
  if (fill.size() < 100) {
    const SphereQuery query(fill);
    test::Numbers numbers;
    for (int k = 0; k < 2000; ++k) {
      const Vec3 p = numbers.Point(0.5).cwiseProduct(Vec3(1, 1, 3));
      EXPECT_LT(query.Nearest(p).distance, 0.1 + 0.06);  // half the spacing, and one lattice step
    }
  }
}

TEST(InnerBalls, FillsNothingWhereBallsAlreadyCover) {
  const Solid cube(MakeBox(Vec3(1, 1, 1)), 0.2);
  EXPECT_TRUE(cube.inner.Fill({{Vec3::Zero(), 2.0}}, 10).empty());
  EXPECT_TRUE(cube.inner.Fill({}, 0).empty());
}

}  // namespace
}  // namespace palpate
