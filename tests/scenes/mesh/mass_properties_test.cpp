#include "scenes/mesh/mass_properties.h"

#include <cmath>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "scenes/shapes/shapes.h"

namespace palpate {
namespace {

// A box by its formulas, wherever it is placed.
TEST(MassProperties, AreThoseOfABox) {
  const Vec3 size(0.02, 0.05, 0.03), s = size.cwiseAbs2();
  const Pose X_WB{Vec3(0.3, -0.2, 1.1), RotationExp(Vec3(0.3, 1.0, -0.4))};
  const auto solid = MassOf(MakeBox(size), X_WB);
  ASSERT_TRUE(solid);
  const double volume = size.prod();
  const Mat3 R = X_WB.q.toRotationMatrix();
  const Mat3 inertia =
      R * (volume / 12.0 * Vec3(s.y() + s.z(), s.x() + s.z(), s.x() + s.y())).asDiagonal() *
      R.transpose();
  EXPECT_NEAR(solid->volume, volume, 1e-14 * volume);
  EXPECT_LE((solid->centre - X_WB.p).norm(), 1e-15);
  EXPECT_LE((solid->inertia - inertia).norm(), 1e-13 * inertia.norm());
}

TEST(MassProperties, AreThoseOfATetrahedron) {
  TriangleMesh mesh;
  mesh.vertices = {Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
  mesh.triangles = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  const auto solid = MassOf(mesh, Pose{});
  ASSERT_TRUE(solid);
  EXPECT_NEAR(solid->volume, 1.0 / 6.0, 1e-16);
  EXPECT_TRUE(solid->centre.isApprox(Vec3::Constant(0.25), 1e-15));
  // About the centre: the integral of x^2 is 1/60 - 1/96, of x y 1/120 - 1/96.
  EXPECT_NEAR(solid->inertia(0, 0), 2.0 * (1.0 / 60.0 - 1.0 / 96.0), 1e-16);
  EXPECT_NEAR(solid->inertia(0, 1), 1.0 / 96.0 - 1.0 / 120.0, 1e-16);
}

TEST(MassProperties, AreOfClosedMeshesAlone) {
  TriangleMesh open = MakeBox(Vec3::Ones());
  open.triangles.pop_back();
  EXPECT_FALSE(MassOf(open, Pose{}));
  TriangleMesh inside_out = MakeBox(Vec3::Ones());
  for (auto& corners : inside_out.triangles) std::swap(corners[0], corners[1]);
  EXPECT_FALSE(MassOf(inside_out, Pose{}));
  EXPECT_FALSE(MassOf(TriangleMesh{}, Pose{}));
}

}  // namespace
}  // namespace palpate
