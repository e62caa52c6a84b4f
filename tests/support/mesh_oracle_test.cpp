#include "tests/support/mesh_oracle.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "scenes/shapes/shapes.h"
#include "tests/support/random.h"
#include "tests/support/triangle_tree.h"

namespace palpate::test {
namespace {

using PlacedMesh = MeshOracle::PlacedMesh;

MeshOracle Against(const TriangleMesh& tool, const TriangleMesh& object, const Pose& X_WB = {}) {
  return MeshOracle(tool, std::array{PlacedMesh{&object, X_WB}});
}

TriangleMesh Sheet() {
  return {{Vec3(-0.5, -0.5, 0), Vec3(0.5, -0.5, 0), Vec3(0.5, 0.5, 0), Vec3(-0.5, 0.5, 0)},
          {{0, 1, 2}, {0, 2, 3}}};
}

TEST(MeshOracle, IsTheDepthOfABoxesCornerInABox) {
  for (const double size : {1e-3, 0.05, 10.0}) {
    const TriangleMesh tool = MakeBox(Vec3::Constant(0.4 * size));
    const Pose X_WB{Vec3(2 * size, 0, 0)};
    const MeshOracle oracle = Against(tool, MakeBox(Vec3::Constant(size)), X_WB);
    // The tool's corner points down into the middle of the top, wholly inside.
    const Quat tilt = RotationExp(Vec3(0.6, 0.1, 0.5));
    double down = 0.0;
    for (const Vec3& v : tool.vertices) down = std::max(down, -(tilt * v).y());
    const auto at = [&](double depth) {
      return oracle.At({Vec3(2 * size, 0.5 * size + down - depth, 0.01 * size), tilt});
    };
    EXPECT_TRUE(at(0.01 * size).meet);
    EXPECT_NEAR(at(0.01 * size).depth, 0.01 * size, 1e-14 * size);
    EXPECT_NEAR(at(1e-9 * size).depth, 1e-9 * size, 1e-14 * size);
    EXPECT_FALSE(at(-1e-9 * size).meet);
    EXPECT_EQ(at(-1e-9 * size).depth, 0.0);
  }
}

TEST(MeshOracle, SeesEdgesThatCrossWithoutAVertexInside) {
  // Two bars crosswise, ridge against ridge: no vertex of one is near the other.
  const TriangleMesh bar = MakeBox(Vec3(1, 0.1, 0.1));
  const Quat on_edge = RotationExp(Vec3(M_PI / 4, 0, 0));
  const Quat across = RotationExp(Vec3(0, M_PI / 2, 0)) * on_edge;
  const double ridge = 0.1 / std::sqrt(2.0);
  const MeshOracle oracle = Against(bar, bar, {Vec3::Zero(), on_edge});
  const auto at = [&](double depth) {
    return oracle.At({Vec3(0.013, 2 * ridge - depth, 0.017), across});
  };
  EXPECT_NEAR(at(2e-3).depth, 2e-3, 1e-12);
  EXPECT_NEAR(at(2e-6).depth, 2e-6, 1e-12);
  EXPECT_FALSE(at(-1e-12).meet);
}

TEST(MeshOracle, SeesWhatIsWhollyInsideAClosedMesh) {
  const TriangleMesh tool = MakeBox(Vec3::Constant(0.02)), object = MakeBox(Vec3::Constant(0.1));
  const MeshOracle inside = Against(tool, object), round = Against(object, tool);
  for (const MeshOracle* oracle : {&inside, &round}) {
    const MeshOracle::Overlap overlap = oracle->At({Vec3(0.005, 0, 0)});
    EXPECT_TRUE(overlap.meet);
    EXPECT_TRUE(oracle->Meet({Vec3(0.005, 0, 0)}));
    EXPECT_EQ(overlap.pairs, 0);
    EXPECT_NEAR(overlap.depth, 0.04, 1e-15) << "its corners at y = 0.01, the walls at 0.05";
  }
}

TEST(MeshOracle, FollowsTheInsideFromWhereTheSurfacesMeet) {
  // A fine ball 8 mm deep in a plate, far deeper than the length of its triangles.
  const double radius = 0.02;
  const TriangleMesh ball = MakeSphere(radius, 5000), plate = MakeBox(Vec3(0.2, 0.05, 0.2));
  const MeshOracle oracle = Against(ball, plate);
  const MeshOracle::Overlap overlap = oracle.At({Vec3(0.001, 0.025 + radius - 0.008, 0.002)});
  double lowest = 0.0;
  for (const Vec3& v : ball.vertices) lowest = std::min(lowest, v.y());
  EXPECT_NEAR(overlap.depth, 0.008 - (radius + lowest), 1e-12);
  EXPECT_GT(overlap.pairs, 50);
}

TEST(MeshOracle, CountsASheetFromBothSides) {
  const TriangleMesh tool = MakeBox(Vec3::Constant(0.02)), sheet = Sheet();
  const MeshOracle oracle = Against(tool, sheet);
  for (const double side : {1.0, -1.0}) {
    // Slightly off the diagonal that the sheet's triangles share.
    const auto at = [&](double depth) {
      return oracle.At({Vec3(0.2, 0.1, side * (0.01 - depth)), RotationExp(Vec3(0, 0, 0.3))});
    };
    EXPECT_FALSE(at(-1e-9).meet);
    EXPECT_TRUE(at(1e-9).meet);
    EXPECT_NEAR(at(0.003).depth, 0.003, 1e-12);
  }
  EXPECT_FALSE(oracle.At({Vec3(0.2, 0.1, 0.5)}).meet) << "an open mesh has no inside";
}

TEST(MeshOracle, TakesFacesThatLieOnEachOtherForATouch) {
  const TriangleMesh box = MakeBox(Vec3::Constant(0.5));
  const MeshOracle oracle = Against(box, box);
  const MeshOracle::Overlap touch = oracle.At({Vec3(0.125, 0.5, 0.25)});
  EXPECT_TRUE(touch.meet);
  EXPECT_EQ(touch.depth, 0.0);
  EXPECT_FALSE(oracle.Meet({Vec3(0.125, std::nextafter(0.5, 1.0), 0.25)}));
}

TEST(MeshOracle, TakesFoldedNonManifoldAndDegenerateMeshes) {
  // Three sheets that share an edge, one of them doubled with the opposite winding, and a needle.
  TriangleMesh fan;
  fan.vertices = {Vec3(0, 0, -1), Vec3(0, 0, 1),   Vec3(1, 0, 0),
                  Vec3(-1, 1, 0), Vec3(-1, -1, 0), Vec3(0, 5, 0)};
  fan.triangles = {{0, 1, 2}, {2, 1, 0}, {0, 1, 3}, {0, 1, 4}, {5, 5, 5}, {5, 0, 5}};
  const TriangleMesh probe = MakeBox(Vec3(0.02, 0.02, 0.3));
  const MeshOracle oracle = Against(probe, fan);
  EXPECT_FALSE(oracle.Meet({Vec3(0.5, 0.0101, 0)}));
  EXPECT_NEAR(oracle.At({Vec3(0.5, 0.007, 0)}).depth, 0.003, 1e-12);
  EXPECT_TRUE(oracle.Meet({Vec3(-0.5, 0.5, 0)}));
  EXPECT_FALSE(oracle.Meet({Vec3(-0.5, 0, 0)})) << "between two sheets";
  EXPECT_TRUE(oracle.Meet({Vec3(0, 5, 0)})) << "a point as a triangle";
}

TEST(MeshOracle, IsWhatTryingEveryPairAndEveryVertexGives) {
  const TriangleMesh tool = MakeEllipsoid(Vec3(0.02, 0.03, 0.01), 320);
  const TriangleMesh object = MakeEllipsoid(Vec3(0.03, 0.01, 0.02), 320);
  const Pose X_WB{Vec3(0.01, 0.02, 0.0), RotationExp(Vec3(0.3, -0.2, 1.0))};
  const MeshOracle oracle = Against(tool, object, X_WB);
  const TriangleTree tool_tree(tool), object_tree(object);
  Random random(7);
  int overlapping = 0;
  for (int i = 0; i < 60; ++i) {
    const Pose X{random.InCube(0.035), random.Rotation()};
    const Pose X_BT = X_WB.Inverse() * X, X_TB = X_BT.Inverse();
    // Equal up to rounding, some 1e-16 m.
    double depth = 0.0;
    long pairs = 0;
    for (std::uint32_t a = 0; a < tool.triangles.size(); ++a) {
      Triangle moved = tool_tree.At(a);
      for (Vec3& p : moved) p = X_BT * p;
      for (std::uint32_t b = 0; b < object.triangles.size(); ++b) {
        if (!Meet(moved, object_tree.At(b))) continue;
        ++pairs;
        depth = std::max(depth, ShortestSeparation(moved, object_tree.At(b)).depth);
      }
    }
    const auto deepen = [&](const TriangleMesh& mesh, const Pose& pose, const TriangleTree& in) {
      for (const Vec3& v : mesh.vertices) {
        // Inside a convex mesh means behind all of its faces.
        bool inside = true;
        double distance = INFINITY;
        for (std::uint32_t t = 0; t < in.triangles(); ++t) {
          const Triangle face = in.At(t);
          const Vec3 n = (face[1] - face[0]).cross(face[2] - face[0]);
          inside &= n.dot(pose * v - face[0]) < 0.0;
          distance = std::min(distance, (NearestPoint(face, pose * v) - pose * v).norm());
        }
        if (inside) depth = std::max(depth, distance);
      }
    };
    deepen(tool, X_BT, object_tree);
    deepen(object, X_TB, tool_tree);
    const MeshOracle::Overlap overlap = oracle.At(X);
    EXPECT_EQ(overlap.pairs, pairs);
    EXPECT_NEAR(overlap.depth, depth, 1e-15);
    EXPECT_EQ(overlap.meet, pairs > 0 || depth > 0.0);
    EXPECT_EQ(oracle.Meet(X), overlap.meet);
    overlapping += overlap.meet;
  }
  EXPECT_GT(overlapping, 10);
  EXPECT_LT(overlapping, 55);
}

TEST(MeshOracle, TakesABallForTheBallAndNotItsMesh) {
  const TriangleMesh cube = MakeBox(Vec3::Constant(0.05));
  const MeshOracle oracle(MeshOracle::ToolBall{Vec3(0, 0.001, 0), 0.005},
                          std::array{PlacedMesh{&cube, {Vec3(1, 0, 0)}}});
  const auto at = [&](double y) { return oracle.At({Vec3(1.001, y - 0.001, 0.002)}); };
  EXPECT_FALSE(at(0.0301).meet);
  EXPECT_NEAR(at(0.0299).depth, 1e-4, 1e-15);
  EXPECT_NEAR(at(0.024).depth, 0.006, 1e-15) << "its centre is inside";
  EXPECT_NEAR(oracle.Distance({Vec3(1, 0.0345, 0)}).distance, 0.0055, 1e-15);
}

TEST(MeshOracle, DistanceIsThatOfTheNearestTriangles) {
  const TriangleMesh tool = MakeEllipsoid(Vec3(0.02, 0.03, 0.01), 80);
  const TriangleMesh object = MakeEllipsoid(Vec3(0.03, 0.01, 0.02), 80);
  const MeshOracle oracle = Against(tool, object);
  const TriangleTree tool_tree(tool), object_tree(object);
  Random random(11);
  for (int i = 0; i < 20; ++i) {
    const Pose X{random.InCube(0.1), random.Rotation()};
    double least = oracle.Meet(X) ? 0.0 : INFINITY;
    for (std::uint32_t a = 0; least > 0.0 && a < tool.triangles.size(); ++a) {
      Triangle moved = tool_tree.At(a);
      for (Vec3& p : moved) p = X * p;
      for (std::uint32_t b = 0; b < object.triangles.size(); ++b) {
        least = std::min(least, NearestPoints(moved, object_tree.At(b)).distance);
      }
    }
    const MeshOracle::Gap gap = oracle.Distance(X);
    EXPECT_NEAR(gap.distance, least, 1e-15);
    if (least == 0.0) continue;
    EXPECT_NEAR((gap.on_tool - gap.on_object).norm(), least, 1e-15);
  }
}

}  // namespace
}  // namespace palpate::test
