#include "scenes/tree/sphere_hierarchy.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <gtest/gtest.h>

#include "tests/scenes/support.h"

namespace palpate {
namespace {

std::vector<Sphere> RandomLeaves(std::size_t count) {
  test::Numbers numbers;
  std::vector<Sphere> leaves;
  for (std::size_t i = 0; i < count; ++i) {
    leaves.push_back({numbers.Point(0.1), numbers.Uniform(0.001, 0.02)});
  }
  return leaves;
}

/// Collects the leaves below a lane, and checks each against every node ball above it.
void Collect(const SphereTree& tree, int level, int packet,
             std::vector<std::array<double, 4>> above, std::vector<int>& found) {
  const SpherePacket& p = tree.level(level)[packet];
  for (int lane = 0; lane < kTreeArity; ++lane) {
    if (p.child[lane] < 0) {
      EXPECT_TRUE(std::isnan(p.x[lane]) && std::isnan(p.radius[lane]));
      continue;
    }
    auto path = above;
    path.push_back({p.x[lane], p.y[lane], p.z[lane], p.radius[lane]});
    if (level + 1 < tree.levels()) {
      Collect(tree, level + 1, p.child[lane], path, found);
      continue;
    }
    const int leaf = p.child[lane];
    found.push_back(leaf);
    for (const auto& [x, y, z, r] : path) {
      const double reach =
          std::hypot(tree.leaf_x[leaf] - x, tree.leaf_y[leaf] - y, tree.leaf_z[leaf] - z) +
          tree.leaf_radius[leaf];
      EXPECT_LE(reach, r * (1 + 1e-15));
    }
  }
}

class LeafCounts : public testing::TestWithParam<std::size_t> {};

TEST_P(LeafCounts, AreAllHeldOnceByNodesAtOneDepthInFullPackets) {
  const std::size_t count = GetParam();
  const auto leaves = RandomLeaves(count);
  const SphereHierarchy h = ArrangeLeaves(leaves);
  const SphereTree& tree = h.tree;
  ASSERT_EQ(tree.leaves(), count);

  std::vector<int> found;
  Collect(tree, 0, 0, {}, found);
  std::vector<int> all(count);
  std::iota(all.begin(), all.end(), 0);
  EXPECT_EQ(found, all);  // in order, too: neighbours in the tree are adjacent in memory

  for (std::size_t i = 0; i < count; ++i) {
    EXPECT_EQ(tree.leaf_radius[i], leaves[h.order[i]].radius);
    EXPECT_EQ(tree.leaf_x[i], leaves[h.order[i]].centre.x());
  }
  // Each level has the fewest packets that can hold the level below.
  std::size_t below = count;
  for (int l = tree.levels() - 1; l >= 0; --l) {
    below = (below + kTreeArity - 1) / kTreeArity;
    EXPECT_EQ(tree.level(l).size(), below);
  }
  EXPECT_EQ(below, 1u);
}

INSTANTIATE_TEST_SUITE_P(SphereHierarchy, LeafCounts,
                         testing::Values(1, 2, 7, 8, 9, 63, 64, 65, 72, 512, 513, 1000, 3076));

TEST(SphereHierarchy, NodesOfDistantClustersDoNotMix) {
  // Eight clusters of eight: the tightest tree has one packet each.
  std::vector<Sphere> leaves;
  test::Numbers numbers;
  for (int i = 0; i < 64; ++i) {
    const int c = (i * 29) % 8;
    leaves.push_back({Vec3(c & 1, c >> 1 & 1, c >> 2) + numbers.Point(0.01), 0.01});
  }
  const SphereTree tree = ArrangeLeaves(leaves).tree;
  for (int lane = 0; lane < kTreeArity; ++lane) {
    EXPECT_LT(tree.level(0)[0].radius[lane], 0.03f);
  }
}

}  // namespace
}  // namespace palpate
