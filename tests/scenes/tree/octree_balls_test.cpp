#include "scenes/tree/octree_balls.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/scenes/support.h"

namespace palpate {
namespace {

std::vector<Sphere> Balls(const TriangleMesh& mesh, std::size_t count) {
  return OctreeBalls(mesh, MeshQuery(mesh), count);
}

TEST(OctreeBalls, AreRoundTheCellsOfACube) {
  const TriangleMesh cube = MakeBox(Vec3(2, 2, 2));
  const std::vector<Sphere> one = Balls(cube, 1);
  ASSERT_EQ(one.size(), 1u);
  EXPECT_LT(one[0].centre.norm(), 1e-12);
  EXPECT_NEAR(one[0].radius, std::sqrt(3.0), 1e-9);
  const std::vector<Sphere> eight = Balls(cube, 8);
  ASSERT_EQ(eight.size(), 8u);
  for (const Sphere& ball : eight) {
    EXPECT_LT((ball.centre.cwiseAbs() - Vec3(0.5, 0.5, 0.5)).norm(), 1e-12);
    EXPECT_NEAR(ball.radius, std::sqrt(3.0) / 2.0, 1e-9);
  }
}

TEST(OctreeBalls, AreAsManyAsTheSplitsAllow) {
  // All eight parts of a cube's cell count, so a split adds seven.
  const TriangleMesh cube = MakeBox(Vec3(2, 2, 2));
  EXPECT_EQ(Balls(cube, 7).size(), 1u);
  EXPECT_EQ(Balls(cube, 14).size(), 8u);
  EXPECT_EQ(Balls(cube, 15).size(), 15u);
  EXPECT_EQ(Balls(cube, 64).size(), 64u);
  for (const TriangleMesh& mesh :
       {MakeEllipsoid(Vec3(0.04, 0.025, 0.03), 1280), MakeBox(Vec3(0.05, 0.001, 0.03)), cube}) {
    for (const std::size_t count : {1, 5, 40, 300, 3076}) {
      const std::size_t made = Balls(mesh, count).size();
      EXPECT_LE(made, count);
      EXPECT_GE(made + 6, count);
    }
  }
}

TEST(OctreeBalls, AreOnlyRoundCellsThatMeetTheSolid) {
  // |x| + |y| + |z| <= 1: a cell meets it if and only if the cell's nearest corner does.
  TriangleMesh octahedron;
  for (int k = 0; k < 3; ++k) {
    octahedron.vertices.push_back(Vec3::Unit(k));
    octahedron.vertices.push_back(-Vec3::Unit(k));
  }
  octahedron.triangles = {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                          {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (const std::size_t count : {100, 1000}) {
    for (const Sphere& ball : Balls(octahedron, count)) {
      const Vec3 half = Vec3::Constant(ball.radius / std::sqrt(3.0));
      const Vec3 nearest = (ball.centre.cwiseAbs() - half).cwiseMax(0.0);
      EXPECT_LE(nearest.sum(), 1.0 + 1e-9) << ball.centre.transpose();
    }
  }
}

TEST(OctreeBalls, HoldTheWholeSolid) {
  const Vec3 axes(0.04, 0.025, 0.03);
  const TriangleMesh mesh = MakeEllipsoid(axes, 1280);
  for (const std::size_t count : {1, 20, 500}) {
    const SphereQuery query(Balls(mesh, count));
    test::Numbers numbers;
    for (int k = 0; k < 3000; ++k) {
      const Vec3 p = numbers.Point(0.04);
      if (p.cwiseQuotient(axes).norm() > 0.98) continue;  // between the mesh and its ellipsoid
      EXPECT_LE(query.Nearest(p).distance, 0.0) << p.transpose();
    }
  }
}

TEST(OctreeBalls, StickOutLessTheMoreTheyAreAndStayLargeInside) {
  const TriangleMesh mesh = MakeSphere(0.03, 5120);
  // From the root's corner, a cell's ball sticks out as far as its parent's.
  double first = 0.0, last = 1.0;
  for (const std::size_t count : {8, 64, 512, 4096}) {
    const std::vector<Sphere> balls = Balls(mesh, count);
    double out = 0.0, largest = 0.0, smallest = 1.0;
    for (const Sphere& ball : balls) {
      out = std::max(out, ball.centre.norm() + ball.radius - 0.03);
      largest = std::max(largest, ball.radius);
      smallest = std::min(smallest, ball.radius);
    }
    EXPECT_LE(out, last * (1.0 + 1e-9));
    if (count == 8) first = out;
    last = out;
    if (count == 4096) {
      EXPECT_LT(out, 0.2 * first);
      EXPECT_GT(largest, 3.9 * smallest);
    }
  }
}

TEST(OctreeBalls, AreTheSameAgain) {
  const TriangleMesh mesh = MakeEllipsoid(Vec3(0.04, 0.025, 0.03), 1280);
  const std::vector<Sphere> a = Balls(mesh, 333), b = Balls(mesh, 333);
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].centre, b[i].centre);
    EXPECT_EQ(a[i].radius, b[i].radius);
  }
}

}  // namespace
}  // namespace palpate
