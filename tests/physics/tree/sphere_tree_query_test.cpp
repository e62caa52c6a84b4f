#include "server/physics/tree/sphere_tree_query.h"

#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/test_trees.h"

namespace palpate {
namespace {

using test::Ball;
using test::MakeTree;
using test::Random;
using test::RandomBalls;

constexpr double kTranslation = 0.5e-3;
constexpr double kRotation = 4e-3;

struct Oracle {
  std::set<std::pair<int, int>> must;  ///< gap at most the enlargement
  std::set<std::pair<int, int>> may;   ///< ... or above it by no more than rounding
};

Oracle AllPairs(const ToolTree& tool, const ObjectForest& objects, const Mat3& R, const Vec3& p) {
  Oracle oracle;
  for (int t = 0; t < static_cast<int>(tool.leaves.size()); ++t) {
    const LeafSphere& a = tool.leaves[static_cast<std::size_t>(t)];
    const Vec3 lever(a.x, a.y, a.z);
    const Vec3 c = R * lever + p;
    const double reach = kTranslation + kRotation * lever.norm();
    for (int o = 0; o < static_cast<int>(objects.leaves.size()); ++o) {
      const LeafSphere& b = objects.leaves[static_cast<std::size_t>(o)];
      const double gap = (c - Vec3(b.x, b.y, b.z)).norm() - a.radius - b.radius;
      if (gap <= reach) oracle.must.insert({t, o});
      if (gap <= reach + 1e-5 * (objects.radius + tool.reach)) oracle.may.insert({t, o});
    }
  }
  return oracle;
}

void CheckAgainstAllPairs(const ToolTree& tool, const ObjectForest& objects, Random& random,
                          double spread, int candidates) {
  PairQuery query(tool, objects);
  std::size_t total = 0;
  for (int candidate = 0; candidate < candidates; ++candidate) {
    const Mat3 R = random.Rotation().toRotationMatrix();
    const Vec3 p = objects.center + random.InCube(spread);
    const Oracle oracle = AllPairs(tool, objects, R, p);
    std::set<std::pair<int, int>> found;
    int given = 0;
    query.Run(ActiveKernels(), R, p, {kTranslation, kRotation},
              [&](const NodePair* pairs, int count) {
                for (int i = 0; i < count; ++i) found.insert({pairs[i].tool, pairs[i].object});
                given += count;
                return true;
              });
    ASSERT_EQ(static_cast<int>(found.size()), given) << "a pair came twice";
    for (const auto& pair : oracle.must) ASSERT_TRUE(found.contains(pair)) << candidate;
    for (const auto& pair : found) ASSERT_TRUE(oracle.may.contains(pair)) << candidate;
    total += oracle.must.size();
  }
  EXPECT_GT(total, 0u) << "no candidate touched anything";
}

TEST(PairQuery, FindsEveryPairThatAllPairsFinds) {
  Random random(21);
  for (const auto& [tool_leaves, object_leaves] :
       {std::pair{1, 1}, {1, 500}, {500, 1}, {8, 9}, {73, 700}, {700, 73}, {600, 600}}) {
    const SphereTree tool_tree = MakeTree(RandomBalls(random, tool_leaves, 0.03, 0.003));
    const SphereTree object_tree = MakeTree(RandomBalls(random, object_leaves, 0.05, 0.004));
    const PlacedTree placed{&object_tree, {random.InCube(0.1), random.Rotation()}};
    const ObjectForest forest(std::span(&placed, 1));
    const ToolTree tool(tool_tree, forest.center.norm() + forest.radius);
    CheckAgainstAllPairs(tool, forest, random, tool_leaves * object_leaves == 1 ? 0.005 : 0.05, 20);
  }
}

TEST(PairQuery, FindsPairsAmongManyObjectsOfDifferentDepth) {
  Random random(22);
  std::vector<SphereTree> trees;
  for (int i = 0; i < 32; ++i) {
    trees.push_back(MakeTree(RandomBalls(random, 1 + random.Below(90), 0.01, 0.002)));
  }
  std::vector<PlacedTree> placed;
  for (const SphereTree& tree : trees) {
    placed.push_back({&tree, {random.InCube(0.05), random.Rotation()}});
  }
  const ObjectForest forest(placed);
  const SphereTree tool_tree = MakeTree(RandomBalls(random, 200, 0.02, 0.002));
  const ToolTree tool(tool_tree, forest.center.norm() + forest.radius);
  CheckAgainstAllPairs(tool, forest, random, 0.05, 30);
  // Leaves are numbered object by object.
  int first = 0;
  for (int i = 0; i < 32; ++i) {
    EXPECT_EQ(forest.first_leaf[static_cast<std::size_t>(i)], first);
    first += static_cast<int>(trees[static_cast<std::size_t>(i)].leaves());
  }
}

TEST(PairQuery, FindsPairsInScenesFromAMillimetreToTenMetres) {
  Random random(23);
  for (const double scale : {0.02, 1.0, 200.0}) {
    const SphereTree tool_tree = MakeTree(RandomBalls(random, 120, 0.02 * scale, 0.003 * scale));
    const SphereTree object_tree = MakeTree(RandomBalls(random, 400, 0.05 * scale, 0.003 * scale));
    const PlacedTree placed{&object_tree, {}};
    const ObjectForest forest(std::span(&placed, 1));
    const ToolTree tool(tool_tree, forest.radius);
    CheckAgainstAllPairs(tool, forest, random, 0.05 * scale, 20);
  }
}

TEST(PairQuery, HandlesMorePairsThanOneBatchHolds) {
  Random random(24);
  std::vector<Ball> heap(300, Ball{Vec3::Zero(), 0.01});
  const SphereTree tree = MakeTree(heap);
  const PlacedTree placed{&tree, {}};
  const ObjectForest forest(std::span(&placed, 1));
  const ToolTree tool(tree, forest.radius);
  PairQuery query(tool, forest);
  int given = 0;
  query.Run(ActiveKernels(), Mat3::Identity(), Vec3::Zero(), {kTranslation, kRotation},
            [&](const NodePair*, int count) {
              given += count;
              return true;
            });
  EXPECT_EQ(given, 300 * 300);
}

}  // namespace
}  // namespace palpate
