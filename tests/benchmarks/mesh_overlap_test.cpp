#include "tests/benchmarks/mesh_overlap.h"

#include <cmath>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "scenes/shapes.h"
#include "tests/support/random.h"

namespace palpate::bench {
namespace {

std::vector<Body> One(TriangleMesh mesh, const Pose& X_WB = {}) {
  std::vector<Body> bodies(1);
  bodies[0].mesh = std::move(mesh);
  bodies[0].X_WB = X_WB;
  return bodies;
}

TEST(MeshOverlap, IsTheDepthOfABoxesCornerInABox) {
  const TriangleMesh tool = MakeBox(Vec3::Constant(0.02));
  const std::vector<Body> cube = One(MakeBox(Vec3::Constant(0.05)), {Vec3(0.1, 0, 0)});
  const MeshOverlap overlap(tool, cube);
  EXPECT_NEAR(overlap.At({Vec3(0.1, 0.025 + 0.01 - 0.003, 0)}), 0.003, 1e-12);
  EXPECT_EQ(overlap.At({Vec3(0.1, 0.0351, 0)}), 0.0);
}

TEST(MeshOverlap, SeesAnObjectsVertexInsideTheTool) {
  // The cube's corner in the middle of a large face of the tool, none of whose vertices is near.
  const TriangleMesh plate = MakeBox(Vec3(1, 0.02, 1));
  const std::vector<Body> cube =
      One(MakeBox(Vec3::Constant(0.05)), {Vec3::Zero(), RotationExp(Vec3(0.6, 0, 0.5))});
  double top = 0.0;
  for (const Vec3& v : cube[0].mesh.vertices) top = std::max(top, (cube[0].X_WB * v).y());
  const MeshOverlap overlap(plate, cube);
  EXPECT_NEAR(overlap.At({Vec3(0, top + 0.01 - 0.004, 0)}), 0.004, 1e-12);
}

TEST(MeshOverlap, IsWhatTryingEveryVertexGives) {
  const TriangleMesh tool = MakeEllipsoid(Vec3(0.02, 0.03, 0.01), 1280);
  const std::vector<Body> object =
      One(MakeEllipsoid(Vec3(0.03, 0.01, 0.02), 1280), {Vec3(0.01, 0.02, 0.0)});
  const MeshOverlap overlap(tool, object);
  const MeshQuery in_tool(tool), in_object(object[0].mesh);
  const auto deepest = [](const TriangleMesh& mesh, const Pose& X, const MeshQuery& in) {
    double depth = 0.0;
    for (const Vec3& v : mesh.vertices) {
      if (in.Inside(X * v)) depth = std::max(depth, in.Nearest(X * v).distance);
    }
    return depth;
  };
  test::Random random(7);
  int overlapping = 0;
  for (int i = 0; i < 40; ++i) {
    const Pose X{random.InCube(0.04), random.Rotation()};
    const Pose X_BT = object[0].X_WB.Inverse() * X;
    const double brute =
        std::max(deepest(tool, X_BT, in_object), deepest(object[0].mesh, X_BT.Inverse(), in_tool));
    EXPECT_EQ(overlap.At(X), brute);
    overlapping += brute > 0.0;
  }
  EXPECT_GT(overlapping, 5);
  EXPECT_LT(overlapping, 35);
}

}  // namespace
}  // namespace palpate::bench
