#include "server/physics/simd/kernels.h"

#include <cstring>
#include <vector>

#include <gtest/gtest.h>

#include "server/physics/contact_rows.h"
#include "server/physics/sphere_tree_query.h"
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
  const ToolTree tool(tool_tree, forest.radius());
  for (int trial = 0; trial < 20; ++trial) {
    const Mat3 R = random.Rotation().toRotationMatrix();
    const Vec3 p = random.InCube(0.06);
    const double x[6] = {1e-4, -2e-4, 3e-4, 1e-5, 2e-5, random.Uniform(-1e-3, 1e-3)};
    std::vector<NodePair> pairs[3];
    ContactRows rows[3] = {{16384, PairQuery::kMaxBatch, 6, 0.03},
                           {16384, PairQuery::kMaxBatch, 6, 0.03},
                           {16384, PairQuery::kMaxBatch, 6, 0.03}};
    ScanResult scan[3];
    for (int k = 0; k < levels; ++k) {
      PairQuery query(tool, forest);
      query.Run(*level[k], R, p, {0.5e-3, 4e-3}, [&](const NodePair* found, int count) {
        pairs[k].insert(pairs[k].end(), found, found + count);
        rows[k].Add(*level[k], tool.leaves().data(), forest.leaves().data(), R, p, found, count);
        return true;
      });
      rows[k].Finish();
      if (rows[k].count() > 0) {
        const QpRows view = rows[k].view();
        level[k]->scan_rows_6(view.a, view.b, (view.count + 15) & ~15, x, scan[k]);
      }
      ASSERT_EQ(pairs[k], pairs[0]) << level[k]->name;
      const QpRows got = rows[k].view(), want = rows[0].view();
      const std::size_t bytes = sizeof(double) * static_cast<std::size_t>(want.count);
      for (int c = 0; c < 6; ++c) {
        ASSERT_EQ(std::memcmp(got.a[c], want.a[c], bytes), 0) << level[k]->name << " column " << c;
      }
      ASSERT_EQ(std::memcmp(got.b, want.b, bytes), 0) << level[k]->name;
      if (want.count > 0) {
        ASSERT_EQ(std::memcmp(&scan[k], &scan[0], sizeof(ScanResult)), 0) << level[k]->name;
      }
    }
  }
}

TEST(Kernels, ScanFindsTheLeastOfEachLane) {
  Random random(12);
  const Kernels* level[3];
  const int levels = AvailableKernels(level);
  constexpr int kRows = 160;
  alignas(64) static double a[6][kRows], b[kRows];
  for (int i = 0; i < kRows; ++i) {
    for (auto& column : a) column[i] = random.Uniform(-1.0, 1.0);
    b[i] = i % 3 == 0 ? 0.0 : random.Uniform(-1.0, 1.0);
  }
  const double x[6] = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};  // ties: the first of equals wins
  const double* columns[6] = {a[0], a[1], a[2], a[3], a[4], a[5]};
  for (int k = 0; k < levels; ++k) {
    ScanResult scan;
    level[k]->scan_rows_6(columns, b, kRows, x, scan);
    for (int lane = 0; lane < 16; ++lane) {
      int best = lane;
      for (int i = lane; i < kRows; i += 16) {
        if (-b[i] < -b[best]) best = i;
      }
      EXPECT_EQ(scan.row[lane], best) << level[k]->name;
      EXPECT_EQ(scan.value[lane], -b[best]) << level[k]->name;
    }
  }
}

}  // namespace
}  // namespace palpate
