#include "server/physics/simd/kernels.h"

#include <cstring>
#include <vector>

#include <gtest/gtest.h>

#include "server/physics/rows/contact_rows.h"
#include "server/physics/tree/sphere_tree_query.h"
#include "tests/support/test_trees.h"

namespace palpate {
namespace {

using test::MakeTree;
using test::Random;
using test::RandomBalls;

TEST(Kernels, GiveTheSameBitsAtEverySimdLevel) {
  const Kernels* level[3];
  const int levels = AvailableKernels(level);
  Random random(11);
  const SphereTree tool_tree = MakeTree(RandomBalls(random, 300, 0.03, 0.004));
  const SphereTree object_tree = MakeTree(RandomBalls(random, 700, 0.05, 0.003));
  const PlacedTree placed{&object_tree, {Vec3(0.01, 0.0, -0.01), random.Rotation()}};
  const ObjectForest forest(std::span(&placed, 1));
  const ToolTree tool(tool_tree, forest.radius(), ToolTree::ReferenceOf(tool_tree));
  for (int trial = 0; trial < 20; ++trial) {
    const Mat3 R = random.Rotation().toRotationMatrix();
    const Vec3 p = random.InCube(0.06);
    const double t[6] = {1e-3, -2e-3, 3e-3, 1e-3, 2e-3, random.Uniform(-1e-3, 1e-3)};
    std::vector<NodePair> pairs[3];
    ContactRows rows[3] = {{16384, PairQuery::kMaxBatch, 6, 0.03},
                           {16384, PairQuery::kMaxBatch, 6, 0.03},
                           {16384, PairQuery::kMaxBatch, 6, 0.03}};
    QpResult solved[3];
    for (int k = 0; k < levels; ++k) {
      PairQuery query(tool, forest);
      query.Run(*level[k], R, p, {0.5e-3, 4e-3}, [&](const NodePair* found, int count) {
        pairs[k].insert(pairs[k].end(), found, found + count);
        rows[k].Add(*level[k], tool.leaves().data(), forest.leaves().data(), R, p, found, count);
        return true;
      });
      rows[k].Finish();
      solved[k] = level[k]->solve_6(t, rows[k].view(), nullptr, 0);
      ASSERT_EQ(pairs[k], pairs[0]) << level[k]->name;
      const QpRows got = rows[k].view(), want = rows[0].view();
      const std::size_t bytes = sizeof(double) * static_cast<std::size_t>(want.count);
      for (int c = 0; c < 6; ++c) {
        ASSERT_EQ(std::memcmp(got.a[c], want.a[c], bytes), 0) << level[k]->name << " column " << c;
      }
      ASSERT_EQ(std::memcmp(got.b, want.b, bytes), 0) << level[k]->name;
      ASSERT_EQ(std::memcmp(solved[k].x, solved[0].x, sizeof(solved[0].x)), 0) << level[k]->name;
      ASSERT_EQ(solved[k].iterations, solved[0].iterations) << level[k]->name;
    }
  }
}

}  // namespace
}  // namespace palpate
