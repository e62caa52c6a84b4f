#include "scenes/shapes/swept_mesh.h"

#include <cmath>

#include <gtest/gtest.h>

#include "scenes/mesh/mesh_query.h"
#include "scenes/mesh/mesh_report.h"

namespace palpate {
namespace {

/// Area of a regular polygon inscribed in the unit circle.
double PolygonArea(int sides) {
  return 0.5 * sides * std::sin(2.0 * M_PI / sides);
}

TEST(SweptMesh, StraightRodIsAPrism) {
  const MeshReport r =
      InspectMesh(MakeRod({Vec3(0, 0, 0), Vec3(1, 1, 0), Vec3(2, 2, 0)}, {0.2, 0.2, 0.2}, 24));
  EXPECT_TRUE(r.solid());
  EXPECT_EQ(r.components, 1u);
  EXPECT_NEAR(r.volume, PolygonArea(24) * 0.04 * 2.0 * std::sqrt(2.0), 1e-12);
}

TEST(SweptMesh, TaperedRodIsAFrustum) {
  const MeshReport r = InspectMesh(MakeRod({Vec3::Zero(), Vec3(0, 0, 3)}, {0.5, 0.1}, 32));
  EXPECT_TRUE(r.solid());
  EXPECT_NEAR(r.volume, PolygonArea(32) * 3.0 / 3.0 * (0.25 + 0.05 + 0.01), 1e-12);
}

TEST(SweptMesh, StraightPipeIsOpenThroughout) {
  const TriangleMesh mesh = MakePipe({Vec3::Zero(), Vec3(0, 0, 1), Vec3(0, 0, 2)}, 0.5, 0.1, 40);
  const MeshReport r = InspectMesh(mesh);
  EXPECT_TRUE(r.solid());
  EXPECT_EQ(r.components, 1u);
  EXPECT_NEAR(r.volume, PolygonArea(40) * (0.36 - 0.25) * 2.0, 1e-12);
  const MeshQuery query(mesh);
  for (double z = -0.5; z < 2.5; z += 0.1) {
    EXPECT_FALSE(query.Inside(Vec3(0.3, 0.2, z)));
    EXPECT_EQ(query.Inside(Vec3(0.55, 0, z)), z > 0.0 && z < 2.0) << z;
  }
}

}  // namespace
}  // namespace palpate
