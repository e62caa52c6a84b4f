#include "scenes/shapes/implicit_mesh.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenes/mesh/mesh_report.h"
#include "tests/scenes/support.h"

namespace palpate {
namespace {

using test::ComplaintOf;
using testing::HasSubstr;

Eigen::AlignedBox3d Cube(double half) {
  return {Vec3::Constant(-half), Vec3::Constant(half)};
}

Field Ball(const Vec3& centre, double radius) {
  return [=](const Vec3& p) { return (p - centre).norm() - radius; };
}

TEST(ImplicitMesh, BallHasItsVerticesOnTheSurfaceAndItsVolume) {
  const TriangleMesh mesh = MeshOfField(Ball(Vec3(0.1, 0, 0), 1.0), Cube(1.5), 0.1);
  const MeshReport r = InspectMesh(mesh);
  EXPECT_TRUE(r.solid());
  EXPECT_EQ(r.components, 1u);
  EXPECT_EQ(r.degenerate_triangles, 0u);
  EXPECT_NEAR(r.volume, 4.0 / 3.0 * M_PI, 0.01);
  EXPECT_NEAR(r.area, 4.0 * M_PI, 0.03);
  for (const Vec3& v : mesh.vertices) EXPECT_NEAR((v - Vec3(0.1, 0, 0)).norm(), 1.0, 1e-9);
}

TEST(ImplicitMesh, StaysClosedWhereTheSurfaceRunsThroughLatticePoints) {
  // A box with its faces in lattice planes, and a ball through lattice points.
  const Field box = [](const Vec3& p) { return p.cwiseAbs().maxCoeff() - 0.5; };
  for (const Field& field : {box, Ball(Vec3::Zero(), 0.5)}) {
    const MeshReport r = InspectMesh(MeshOfField(field, Cube(1.0), 0.125));
    EXPECT_TRUE(r.solid());
    EXPECT_GT(r.volume, 0.0);
  }
}

TEST(ImplicitMesh, TorusHasAHole) {
  const Field torus = [](const Vec3& p) {
    return std::hypot(std::hypot(p.x(), p.z()) - 1.0, p.y()) - 0.3;
  };
  const TriangleMesh mesh = MeshOfField(torus, Cube(1.6), 0.1);
  const MeshReport r = InspectMesh(mesh);
  EXPECT_TRUE(r.solid());
  const auto v = std::ptrdiff_t(mesh.vertices.size());
  const auto t = std::ptrdiff_t(mesh.triangles.size());
  EXPECT_EQ(v - 3 * t / 2 + t, 0);  // Euler's characteristic
  EXPECT_NEAR(r.volume, 2.0 * M_PI * M_PI * 0.09, 0.02);
}

TEST(ImplicitMesh, TrianglesAreNearlyEquilateral) {
  const TriangleMesh mesh = MeshOfField(Ball(Vec3::Zero(), 1.0), Cube(1.3), 0.1);
  double worst = 1.0;
  double mean = 0.0;
  for (const auto& [i, j, k] : mesh.triangles) {
    const Vec3 a = mesh.vertices[j] - mesh.vertices[i];
    const Vec3 b = mesh.vertices[k] - mesh.vertices[j];
    const Vec3 c = mesh.vertices[i] - mesh.vertices[k];
    // 1 for equilateral triangles, 0 for slivers.
    const double quality = 2.0 * std::sqrt(3.0) * a.cross(b).norm() /
                           (a.squaredNorm() + b.squaredNorm() + c.squaredNorm());
    worst = std::min(worst, quality);
    mean += quality / double(mesh.triangles.size());
  }
  EXPECT_GT(worst, 0.2);
  EXPECT_GT(mean, 0.85);
}

TEST(ImplicitMesh, SmoothUnionHoldsBothAndIsNearlyThePlainOneFarFromTheSeam) {
  const Field both = UnionOf({Ball(Vec3(-1, 0, 0), 0.5), Ball(Vec3(1, 0, 0), 0.5)}, 0.2);
  EXPECT_EQ(both(Vec3(-1, 0, 0)), -0.5);
  EXPECT_EQ(both(Vec3(2, 0, 0)), 0.5);
  EXPECT_LT(both(Vec3(0, 0, 0)), 0.5);
  EXPECT_EQ(SmoothMax(1.0, 3.0, 1.0), 3.0);
  EXPECT_EQ(SmoothMax(2.0, 2.0, 1.0), 2.25);
  const Field hollow = Without(Ball(Vec3::Zero(), 1.0), Ball(Vec3::Zero(), 0.5), 0.1);
  EXPECT_EQ(hollow(Vec3(0.1, 0, 0)), 0.4);
}

TEST(ImplicitMesh, ConesEllipsoidsAndRopesAreZeroOnTheirSurface) {
  const Field cone = ConeField(Vec3(0, 0, 0), 0.5, Vec3(0, 2, 0), 0.1);
  EXPECT_NEAR(cone(Vec3(0, -0.5, 0)), 0.0, 1e-15);
  EXPECT_NEAR(cone(Vec3(0, 2.1, 0)), 0.0, 1e-15);
  EXPECT_NEAR(cone(Vec3(0.3, 1, 0)), 0.0, 1e-15);
  const Field ellipsoid = EllipsoidField(Vec3(1, 0, 0), Vec3(1, 2, 3));
  EXPECT_NEAR(ellipsoid(Vec3(1, 2, 0)), 0.0, 1e-15);
  EXPECT_LT(ellipsoid(Vec3(1, 0, 0)), 0.0);
  const Field rope = RopeField({Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(1, 1, 0)}, 0.2);
  EXPECT_NEAR(rope(Vec3(0.5, 0.2, 0)), 0.0, 1e-15);
  EXPECT_NEAR(rope(Vec3(1.2, 0.5, 0)), 0.0, 1e-15);
}

TEST(ImplicitMesh, SaysWhereASurfaceLeavesItsBoxOrThereIsNone) {
  EXPECT_THAT(ComplaintOf([] { MeshOfField(Ball(Vec3::Zero(), 2.0), Cube(1.0), 0.1); }),
              HasSubstr("leaves its box"));
  EXPECT_THAT(ComplaintOf([] { MeshOfField(Ball(Vec3::Zero(), -1.0), Cube(1.0), 0.1); }),
              HasSubstr("is empty"));
}

}  // namespace
}  // namespace palpate
