#include "server/physics/surface/hull_tree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "scenes/shapes/shapes.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

using test::Random;

ContactMesh MeshAlone(const TriangleMesh& mesh) {
  return ContactMesh(mesh);
}

std::vector<std::uint32_t> Below(const HullTree& tree, HullTree::Node node) {
  if (HullTree::IsLeaf(node)) return {HullTree::TriangleOf(node)};
  std::vector<std::uint32_t> all;
  for (const HullTree::Node child : tree.inner(node).child) {
    const std::vector<std::uint32_t> part = Below(tree, child);
    all.insert(all.end(), part.begin(), part.end());
  }
  return all;
}

/// Checks at every node what users of the tree rely on.
void Judge(const TriangleMesh& source, double size) {
  const ContactMesh mesh = MeshAlone(source);
  const HullTree tree(mesh);
  const Kernels& kernels = ActiveKernels();
  Random random(41);
  std::vector<int> seen(mesh.triangles().size(), 0);
  std::vector<HullTree::Node> left{tree.root()};
  while (!left.empty()) {
    const HullTree::Node node = left.back();
    left.pop_back();
    const std::vector<std::uint32_t> below = Below(tree, node);
    for (int candidate = 0; candidate < 6; ++candidate) {
      // Not only of unit length.
      const Vec3 n =
          (candidate == 0 ? Vec3(Vec3::UnitZ()) : random.Direction()) * (1.0 + candidate % 3);
      double highest = -std::numeric_limits<double>::infinity();
      for (const std::uint32_t t : below) {
        for (int c = 0; c < 3; ++c) highest = std::max(highest, n.dot(mesh.Corner(t, c)));
      }
      const double told = tree.Highest(node, n, kernels);
      EXPECT_GE(told, highest - 1e-15 * size);
      EXPECT_NEAR(n.dot(tree.HullOf(node).Lowest(-n, kernels)), told, 1e-15 * size);
      const HullTree::OrientedBox* box = tree.HullOf(node).box;
      EXPECT_TRUE(box == nullptr || below.size() > 32);
      // Too high by at most the size of the box.
      const double slack = box == nullptr ? 1e-15 * size : 2.1 * n.norm() * box->sides.norm();
      EXPECT_LE(told, highest + slack);
    }
    for (const std::uint32_t t : below) {
      for (int c = 0; c < 3; ++c) {
        EXPECT_LE((mesh.Corner(t, c) - tree.Centre(node)).norm(), tree.Radius(node) + 1e-15 * size);
      }
    }
    if (HullTree::IsLeaf(node)) {
      ++seen[HullTree::TriangleOf(node)];
      EXPECT_FALSE(tree.IsLarger(node, tree, node));
      continue;
    }
    if (const HullTree::OrientedBox* box = tree.HullOf(node).box) {
      const Mat3 squares = box->sides.transpose() * box->sides;
      const Vec3 lengths2 = squares.diagonal();
      EXPECT_LE((squares - Mat3(lengths2.asDiagonal())).cwiseAbs().maxCoeff(),
                1e-12 * lengths2.maxCoeff());
      EXPECT_LE(lengths2[0], lengths2[1] * (1.0 + 1e-12));
      EXPECT_LE(lengths2[1], lengths2[2] * (1.0 + 1e-12));
    }
    EXPECT_TRUE(tree.IsLarger(node, tree, node));
    for (const HullTree::Node child : tree.inner(node).child) {
      // A triangle is never opened, not even beside a point.
      if (HullTree::IsLeaf(child)) {
        EXPECT_FALSE(tree.IsLarger(child, tree, node));
        EXPECT_TRUE(tree.IsLarger(node, tree, child));
      } else if (tree.Radius(child) < tree.Radius(node)) {
        EXPECT_FALSE(tree.IsLarger(child, tree, node));
      }
      left.push_back(child);
    }
  }
  for (const int times : seen) EXPECT_EQ(times, 1);
}

TriangleMesh CoplanarGrid(int n, double spacing) {
  TriangleMesh grid;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) grid.vertices.push_back(Vec3(i * spacing, j * spacing, 0.0));
  }
  const auto at = [n](int i, int j) { return static_cast<std::uint32_t>(i * (n + 1) + j); };
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      grid.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      grid.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return grid;
}

TEST(HullTree, HoldsEveryTriangleInEveryNodeAboveIt) {
  Judge(MakeEllipsoid(Vec3(0.04, 0.025, 0.03), 1280), 0.1);
  Judge(MakeBox(Vec3(0.06, 0.05, 1e-4)), 0.1);
  Judge(MakeBentPipe(0.01, 0.002, 0.1, 0.05), 0.1);
}

TEST(HullTree, HoldsRandomSoupsOfAnySize) {
  for (const double size : {1e-3, 1.0, 10.0}) {
    Random random(42);
    for (const int count : {2, 3, 5, 64, 333}) {
      TriangleMesh soup;
      for (int t = 0; t < count; ++t) {
        const Vec3 at = random.InCube(size);
        const auto first = static_cast<std::uint32_t>(soup.vertices.size());
        for (int c = 0; c < 3; ++c) soup.vertices.push_back(at + random.InCube(0.1 * size));
        soup.triangles.push_back({first, first + 1, first + 2});
      }
      Judge(soup, size);
    }
  }
}

TEST(HullTree, IsOneTriangleWhereThereIsOne) {
  TriangleMesh one;
  one.vertices = {Vec3(0.01, 0, 0), Vec3(0, 0.02, 0), Vec3(0, 0, 0.03)};
  one.triangles = {{0, 1, 2}};
  const ContactMesh mesh = MeshAlone(one);
  const HullTree tree(mesh);
  ASSERT_TRUE(HullTree::IsLeaf(tree.root()));
  EXPECT_EQ(HullTree::TriangleOf(tree.root()), 0u);
  EXPECT_EQ(tree.Highest(tree.root(), Vec3::UnitZ(), ActiveKernels()), 0.03);
  const ContactMesh point = ContactMesh::Point();
  const HullTree of_point(point);
  EXPECT_TRUE(HullTree::IsLeaf(of_point.root()));
  EXPECT_EQ(of_point.Radius(of_point.root()), 0.0);
}

TEST(HullTree, HoldsATriangleThatIsThereAHundredTimes) {
  TriangleMesh many;
  many.vertices = {Vec3(0.01, 0, 0), Vec3(0, 0.02, 0), Vec3(0, 0, 0.03)};
  many.triangles.assign(100, {0, 1, 2});
  Judge(many, 0.1);
}

TEST(HullTree, HoldsTrianglesWithoutArea) {
  TriangleMesh line;
  for (int i = 0; i < 20; ++i) line.vertices.push_back(Vec3(0.001 * i, 0.002 * i, 0.0));
  for (std::uint32_t i = 0; i + 2 < 20; ++i) line.triangles.push_back({i, i + 1, i + 2});
  for (std::uint32_t i = 0; i < 20; ++i) line.triangles.push_back({i, i, i});
  Judge(line, 0.1);
  TriangleMesh place;
  place.vertices = {Vec3(1.0, 2.0, 3.0)};
  place.triangles.assign(5, {0, 0, 0});
  Judge(place, 4.0);
}

/// FNV-1a over the bits of all nodes, and of one hull vertex of each.
std::uint64_t HashOf(const HullTree& tree) {
  std::uint64_t hash = 14695981039346656037u;
  const auto mix = [&hash](const auto& value) {
    for (const auto byte : std::bit_cast<std::array<unsigned char, sizeof value>>(value)) {
      hash = (hash ^ byte) * 1099511628211u;
    }
  };
  const auto mix_all = [&mix](const auto& matrix) {
    for (const double x : matrix.reshaped()) mix(x);
  };
  struct Below {
    HullTree::Node parent, node;
  };
  std::vector<Below> left{{-1, tree.root()}};
  while (!left.empty()) {
    const auto [parent, node] = left.back();
    left.pop_back();
    mix(node);
    mix(parent);
    mix(tree.Radius(node));
    mix_all(tree.Centre(node));
    mix_all(tree.HullOf(node).Lowest(Vec3(0.3, 0.5, -0.8), ActiveKernels()));
    if (HullTree::IsLeaf(node)) continue;
    if (const HullTree::OrientedBox* box = tree.HullOf(node).box) mix_all(box->sides);
    for (const HullTree::Node child : tree.inner(node).child) left.push_back({node, child});
  }
  return hash;
}

// Halves of large patches are built in threads.  The hash is that of a tree built by one thread,
// which sorted every patch by comparison.
TEST(HullTree, HasTheBitsThatOneThreadMakes) {
  TriangleMesh hills = CoplanarGrid(270, 3.7e-4);
  for (Vec3& v : hills.vertices) {
    v.z() = 30.0 * v.x() * v.y() * (0.1 - v.x()) - 4.0 * v.y() * v.y() * (v.x() - 0.03);
  }
  hills.vertices.push_back(Vec3(2.0, 1.0, 0.5));  // far off: all others fall into one bucket
  hills.triangles.push_back({0, 1, static_cast<std::uint32_t>(hills.vertices.size() - 1)});
  EXPECT_EQ(HashOf(HullTree(MeshAlone(hills))), 10544356242272076777u);
}

// The purpose of boxes and hulls: a flat patch in any orientation is bounded by a tight plane.
TEST(HullTree, IsThinWhereTheSurfaceIsFlat) {
  TriangleMesh grid = CoplanarGrid(16, 0.005);
  Judge(grid, 0.1);
  const Quat q(Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()));
  for (Vec3& v : grid.vertices) v = q * v + Vec3(0.1, 0.2, -0.1);
  const Vec3 n = q * Vec3::UnitZ();
  const double height = n.dot(grid.vertices[0]);
  const ContactMesh mesh = MeshAlone(grid);
  const HullTree tree(mesh);
  std::vector<HullTree::Node> left{tree.root()};
  while (!left.empty()) {
    const HullTree::Node node = left.back();
    left.pop_back();
    EXPECT_NEAR(tree.Highest(node, n, ActiveKernels()), height, 1e-9);
    EXPECT_NEAR(tree.Highest(node, -n, ActiveKernels()), -height, 1e-9);
    if (HullTree::IsLeaf(node)) continue;
    for (const HullTree::Node child : tree.inner(node).child) left.push_back(child);
  }
}

}  // namespace
}  // namespace palpate
