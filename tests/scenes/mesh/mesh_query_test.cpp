#include "scenes/mesh/mesh_query.h"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/scenes/support.h"
#include "tests/support/dirty_mesh.h"

namespace palpate {
namespace {

using test::Numbers;

/// The nearest of a fine grid of the triangle's points: hardly farther than the truth.
double GridDistance(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c, int steps) {
  double best = 1e300;
  for (int i = 0; i <= steps; ++i) {
    for (int j = 0; i + j <= steps; ++j) {
      const double u = double(i) / steps;
      const double v = double(j) / steps;
      best = std::min(best, (p - ((1 - u - v) * a + u * b + v * c)).norm());
    }
  }
  return best;
}

TEST(NearestOnTriangle, AgreesWithAGridOfPoints) {
  Numbers numbers;
  for (int k = 0; k < 200; ++k) {
    const Vec3 a = numbers.Point(1), b = numbers.Point(1), c = numbers.Point(1);
    const Vec3 p = numbers.Point(2);
    const double distance = (NearestOnTriangle(p, a, b, c) - p).norm();
    const double grid = GridDistance(p, a, b, c, 60);
    EXPECT_LE(distance, grid + 1e-12);
    EXPECT_GE(distance, grid - 4.0 / 60);
  }
}

TEST(NearestOnTriangle, TreatsATriangleWithoutAreaAsASegmentOrAPoint) {
  const Vec3 a(0, 0, 0), b(1, 0, 0), c(2, 0, 0);
  for (const auto& [i, j, k] : {std::tuple{a, b, c}, {b, c, a}, {c, a, b}, {b, a, c}}) {
    EXPECT_NEAR((NearestOnTriangle(Vec3(1.5, 1, 0), i, j, k) - Vec3(1.5, 0, 0)).norm(), 0, 1e-15);
    EXPECT_NEAR((NearestOnTriangle(Vec3(5, 1, 0), i, j, k) - c).norm(), 0, 1e-15);
  }
  EXPECT_EQ(NearestOnTriangle(Vec3(5, 1, 0), b, b, b), b);
}

TEST(MeshQuery, FindsTheSameNearestDistanceAsLookingAtEveryTriangle) {
  Numbers numbers;
  const TriangleMesh mesh = test::TriangleSoup(numbers, 500, 0.2);
  const MeshQuery query(mesh);
  for (int k = 0; k < 500; ++k) {
    const Vec3 p = numbers.Point(1.5);
    double best = 1e300;
    for (const auto& [a, b, c] : mesh.triangles) {
      best = std::min(
          best,
          (NearestOnTriangle(p, mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]) - p).norm());
    }
    const MeshQuery::Hit hit = query.Nearest(p);
    EXPECT_DOUBLE_EQ(hit.distance, best);
    const auto& [a, b, c] = mesh.triangles[hit.triangle];
    EXPECT_EQ(hit.point,
              NearestOnTriangle(p, mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]));
    EXPECT_EQ(query.Nearest(p, 0.999 * best).triangle, MeshQuery::kNone);
    EXPECT_EQ(query.Nearest(p, 1.001 * best).triangle, hit.triangle);
  }
}

TEST(MeshQuery, KnowsTheInsideOfABoxAndOfAnEllipsoid) {
  const TriangleMesh box = MakeBox(Vec3(2, 2, 2));
  const TriangleMesh ellipsoid = MakeEllipsoid(Vec3(1.0, 0.5, 0.7), 5120);
  const MeshQuery in_box(box);
  const MeshQuery in_ellipsoid(ellipsoid);
  Numbers numbers;
  for (int k = 0; k < 2000; ++k) {
    const Vec3 p = numbers.Point(1.5);
    const double to_box = p.cwiseAbs().maxCoeff() - 1.0;
    EXPECT_EQ(in_box.Inside(p), to_box < 0);
    const double f = p.cwiseQuotient(Vec3(1.0, 0.5, 0.7)).norm();
    if (std::abs(f - 1.0) < 0.01) continue;  // between the facets and the true surface
    EXPECT_EQ(in_ellipsoid.Inside(p), f < 1.0);
  }
}

TEST(MeshQuery, WindingNumberNearlyEqualsTheSumOfAllSolidAngles) {
  // An open mesh from all around: no rounding to 0 or 1 hides the dipoles' error.
  TriangleMesh open = MakeEllipsoid(Vec3(1.0, 0.5, 0.7), 1280);
  open.triangles.resize(open.triangles.size() * 2 / 3);
  const MeshQuery query(open);
  Numbers numbers;
  for (int k = 0; k < 500; ++k) {
    const Vec3 p = numbers.Point(2);
    EXPECT_NEAR(query.WindingNumber(p), test::BruteWinding(open, p), 0.03);
  }
}

TEST(MeshQuery, StillTellsTheInsideOfAMeshWithASmallHole) {
  TriangleMesh open = MakeSphere(1.0, 1280);
  open.triangles.erase(open.triangles.begin(), open.triangles.begin() + 5);
  const MeshQuery query(open);
  EXPECT_TRUE(query.Inside(Vec3::Zero()));
  EXPECT_FALSE(query.Inside(Vec3(1.5, 0, 0)));
}

TEST(MeshQuery, SmoothNormalOfASphereIsItsRadius) {
  const TriangleMesh sphere = MakeSphere(1.0, 5120);
  const MeshQuery query(sphere);
  Numbers numbers;
  for (int k = 0; k < 200; ++k) {
    const Vec3 direction = numbers.Point(1).normalized();
    const MeshQuery::Hit hit = query.Nearest(2 * direction);
    EXPECT_GT(query.SmoothNormal(hit.triangle, hit.point).dot(direction), 0.9995);
    EXPECT_GT(query.FaceNormal(hit.triangle).dot(direction), 0.995);
  }
}

}  // namespace
}  // namespace palpate
