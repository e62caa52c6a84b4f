#include "scenes/mesh/mesh_simplify.h"

#include <cmath>

#include <gtest/gtest.h>

#include "scenes/mesh/mesh_report.h"
#include "scenes/shapes/implicit_mesh.h"

namespace palpate {
namespace {

const Eigen::AlignedBox3d kBox{Vec3::Constant(-1.6), Vec3::Constant(1.6)};

TEST(MeshSimplify, LeavesASolidOfTheSameShapeWithFewerTriangles) {
  const Field torus = [](const Vec3& p) {
    return std::hypot(std::hypot(p.x(), p.z()) - 1.0, p.y()) - 0.3;
  };
  const TriangleMesh fine = MeshOfField(torus, kBox, 0.1);
  const TriangleMesh few = Simplified(fine, 0.01);
  EXPECT_LT(few.triangles.size(), fine.triangles.size() / 3);
  const MeshReport r = InspectMesh(few);
  EXPECT_TRUE(r.solid());
  EXPECT_EQ(r.degenerate_triangles, 0u);
  EXPECT_EQ(r.duplicate_triangles, 0u);
  const auto v = std::ptrdiff_t(few.vertices.size());
  const auto t = std::ptrdiff_t(few.triangles.size());
  EXPECT_EQ(v - 3 * t / 2 + t, 0);  // Euler's characteristic: the hole is kept
  for (const Vec3& p : few.vertices) EXPECT_NEAR(torus(p), 0.0, 1e-9);
  for (const auto& [a, b, c] : few.triangles) {
    EXPECT_LT(std::abs(torus((few.vertices[a] + few.vertices[b] + few.vertices[c]) / 3.0)), 0.04);
  }
}

TEST(MeshSimplify, ChangesNothingWhereNothingMayMove) {
  const TriangleMesh fine = MeshOfField([](const Vec3& p) { return p.norm() - 1.0; }, kBox, 0.2);
  EXPECT_EQ(Simplified(fine, 1e-9).triangles, fine.triangles);
}

}  // namespace
}  // namespace palpate
