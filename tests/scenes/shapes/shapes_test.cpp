#include "scenes/shapes/shapes.h"

#include <gtest/gtest.h>

#include "scenes/mesh/mesh_report.h"

namespace palpate {
namespace {

TEST(Shapes, EllipsoidHasItsVerticesOnTheSurfaceAndAtLeastTheTrianglesAskedFor) {
  const Vec3 axes(0.04, 0.025, 0.03);
  const TriangleMesh mesh = MakeEllipsoid(axes, 1000);
  EXPECT_EQ(mesh.triangles.size(), 1280u);
  for (const Vec3& v : mesh.vertices) EXPECT_NEAR(v.cwiseQuotient(axes).norm(), 1.0, 1e-12);
  const MeshReport r = InspectMesh(mesh);
  EXPECT_TRUE(r.solid());
  EXPECT_FALSE(r.inside_out());
  // The solid's volume 4/3 pi abc, minus what the facets cut off.
  EXPECT_NEAR(r.volume / (4.0 / 3.0 * 3.14159265358979 * axes.prod()), 0.99, 0.01);
}

TEST(Shapes, CoarsestSphereIsAnIcosahedron) {
  const TriangleMesh mesh = MakeSphere(1.0, 1);
  EXPECT_EQ(mesh.triangles.size(), 20u);
  EXPECT_EQ(mesh.vertices.size(), 12u);
  // Volume for a circumradius of 1.
  EXPECT_NEAR(InspectMesh(mesh).volume, 2.53615071012041, 1e-12);
}

}  // namespace
}  // namespace palpate
