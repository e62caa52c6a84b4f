#include "server/physics/simd/kernels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "common/qp/nearest_point.h"
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
  const ToolTree tool(tool_tree, forest.radius);
  for (int candidate = 0; candidate < 20; ++candidate) {
    const Mat3 R = random.Rotation().toRotationMatrix();
    const Vec3 p = random.InCube(0.06);
    const double t[6] = {1e-3, -2e-3, 3e-3, 1e-3, 2e-3, random.Uniform(-1e-3, 1e-3)};
    std::vector<NodePair> pairs[3];
    ContactRows rows[3] = {{16384, 0.03}, {16384, 0.03}, {16384, 0.03}};
    QpResult solved[3];
    for (int k = 0; k < levels; ++k) {
      PairQuery query(tool, forest);
      query.Run(*level[k], R, p, {0.5e-3, 4e-3}, [&](const NodePair* found, int count) {
        pairs[k].insert(pairs[k].end(), found, found + count);
        return rows[k].Add(*level[k], tool.leaves.data(), forest.leaves.data(), R, p, found, count);
      });
      rows[k].Finish();
      solved[k] = level[k]->solve(t, rows[k].view(), nullptr, 0);
      ASSERT_EQ(pairs[k], pairs[0]) << level[k]->name;
      const QpRows got = rows[k].view(), want = rows[0].view();
      const std::size_t bytes = sizeof(double) * static_cast<std::size_t>(want.count);
      for (int c = 0; c < 6; ++c) {
        ASSERT_EQ(std::memcmp(got.a[c], want.a[c], bytes), 0) << level[k]->name << " column " << c;
      }
      ASSERT_EQ(std::memcmp(got.b, want.b, bytes), 0) << level[k]->name;
      const QpResult truth = SolveNearestPoint(t, want, nullptr, 0);
      ASSERT_EQ(std::memcmp(solved[k].x, truth.x, sizeof(truth.x)), 0) << level[k]->name;
      ASSERT_EQ(solved[k].iterations, truth.iterations) << level[k]->name;
    }
  }
}

/// Columns as PlaneColumns requires: aligned, and padded to a multiple of eight.
struct AlignedColumn {
  explicit AlignedColumn(int count) : value(static_cast<std::size_t>(count) / 8 + 1) {}
  double* data() { return value[0].v; }
  struct alignas(64) Eight {
    double v[8] = {1e300, 1e300, 1e300, 1e300, 1e300, 1e300, 1e300, 1e300};
  };
  std::vector<Eight> value;
};

TEST(Kernels, FindWhatIsBelowALimitAtEverySimdLevel) {
  const Kernels* level[3];
  const int levels = AvailableKernels(level);
  Random random(12);
  for (int count = 0; count <= 33; ++count) {
    AlignedColumn column(count);
    for (int i = 0; i < count; ++i) {
      // Some at the limit itself, and some infinite, like those of open pairs.
      const int kind = random.Below(6);
      column.data()[i] = kind == 0   ? 0.25
                         : kind == 1 ? std::numeric_limits<double>::infinity()
                                     : random.Uniform(-1.0, 1.0);
    }
    std::vector<std::int32_t> want;
    for (int i = 0; i < count; ++i) {
      if (column.data()[i] < 0.25) want.push_back(i);
    }
    for (int k = 0; k < levels; ++k) {
      std::vector<std::int32_t> got(static_cast<std::size_t>(count) + 8, -1);
      const int found = level[k]->find_below(column.data(), count, 0.25, got.data());
      got.resize(static_cast<std::size_t>(found));
      ASSERT_EQ(got, want) << level[k]->name << ", " << count << " values";
    }
  }
}

/// Returns |n x phi| of a plane.
double TurnedOf(const PlaneColumns& planes, int i, const PlaneMotion& motion) {
  const Vec3 n(planes.along[0][i], planes.along[1][i], planes.along[2][i]);
  return n.cross(Vec3::Map(motion.step + 3)).norm();
}

TEST(Kernels, FindThePlanesThatAMotionUsesUpAtEverySimdLevel) {
  const Kernels* level[3];
  const int levels = AvailableKernels(level);
  Random random(13);
  for (int count = 0; count <= 33; ++count) {
    std::vector<AlignedColumn> column(9, AlignedColumn(count));
    PlaneColumns planes{};
    for (int c = 0; c < 6; ++c) planes.along[c] = column[static_cast<std::size_t>(c)].data();
    planes.slack = column[6].data();
    planes.radius = column[7].data();
    planes.left = column[8].data();
    // Entries beyond the last are left from an earlier sub-step: arbitrary, and not to be found.
    for (int i = 0; i < (count | 7) + 1; ++i) {
      for (int c = 0; c < 6; ++c) planes.along[c][i] = random.Uniform(-1.0, 1.0);
      planes.slack[i] = random.Below(8) == 0 ? std::numeric_limits<double>::infinity()
                                             : random.Uniform(-0.2, 1.0);
      planes.radius[i] = random.Uniform(0.0, 0.5);
    }
    PlaneMotion motion{{}, 0.1, 0.2};
    for (double& s : motion.step) s = random.Uniform(-0.5, 0.5);
    for (int first = 0; first <= count; ++first) {
      std::vector<std::int32_t> want;
      bool close = false;
      for (int i = first; i < count; ++i) {
        double left = planes.slack[i] - TurnedOf(planes, i, motion) * planes.radius[i];
        for (int c = 0; c < 6; ++c) left += planes.along[c][i] * motion.step[c];
        close |= std::abs(left - motion.least_new) < 1e-12;
        if (planes.slack[i] < motion.least_old || left < motion.least_new) want.push_back(i);
      }
      ASSERT_FALSE(close) << "another seed: rounding would decide";
      for (int k = 0; k < levels; ++k) {
        std::vector<std::int32_t> got(static_cast<std::size_t>(count) + 8, -1);
        const int found = level[k]->find_used_up(planes, first, count, motion, got.data());
        got.resize(static_cast<std::size_t>(found));
        ASSERT_EQ(got, want) << level[k]->name << ", from " << first << " to " << count;
        for (const std::int32_t i : got) {
          double left = planes.slack[i] - TurnedOf(planes, i, motion) * planes.radius[i];
          for (int c = 0; c < 6; ++c) left += planes.along[c][i] * motion.step[c];
          if (std::isfinite(left)) {
            ASSERT_NEAR(planes.left[i], left, 1e-14);
          }
        }
      }
    }
  }
}

TEST(Kernels, FindTheLowestPointAtEverySimdLevel) {
  const Kernels* level[3];
  const int levels = AvailableKernels(level);
  Random random(16);
  for (int candidate = 0; candidate < 2000; ++candidate) {
    const int count = candidate % 2 == 0 ? 1 : 1 + candidate % 33;
    // A single group of eight has any lanes but none; of several groups, all have every lane.
    const std::uint32_t lanes =
        count == 1 ? 1 + static_cast<std::uint32_t>(candidate / 2) % 255 : 0xff;
    std::vector<EightPoints> points(static_cast<std::size_t>(count));
    for (EightPoints& eight : points) {
      // Coarse, so that several are equally low.
      for (auto& row : eight.x) {
        for (double& x : row)
          x = candidate % 3 == 0 ? std::round(random.Uniform(-2, 2)) : random.Uniform(-0.1, 0.1);
      }
    }
    const Vec3 m =
        candidate % 3 == 0 ? Vec3(0.0, candidate % 5 == 0 ? 0.0 : 1.0, -1.0) : random.Direction();
    const auto along = [&](int i) {
      const EightPoints& eight = points[static_cast<std::size_t>(i / 8)];
      return m.dot(Vec3(eight.x[0][i % 8], eight.x[1][i % 8], eight.x[2][i % 8]));
    };
    double lowest = std::numeric_limits<double>::infinity();
    for (int i = 0; i < 8 * count; ++i) {
      if ((lanes >> (i % 8) & 1u) != 0) lowest = std::min(lowest, along(i));
    }
    const int first = level[0]->lowest_point(points.data(), count, lanes, m.data());
    ASSERT_TRUE(first >= 0 && first < 8 * count && (lanes >> (first % 8) & 1u) != 0);
    ASSERT_NEAR(along(first), lowest, 1e-15) << "candidate " << candidate;
    for (int l = 1; l < levels; ++l) {
      ASSERT_EQ(level[l]->lowest_point(points.data(), count, lanes, m.data()), first)
          << level[l]->name << ", candidate " << candidate;
    }
  }
}

// To the last bit those of MeshPair::Gap, which computes one at a time.
TEST(Kernels, FindTheGapsOfTrianglesAtEverySimdLevel) {
  const Kernels* level[3];
  const int levels = AvailableKernels(level);
  Random random(16);
  for (int candidate = 0; candidate < 500; ++candidate) {
    struct {
      Vec3 p;
      Mat3 R;
    } at[3];
    for (auto& X : at) X = {random.InCube(0.1), random.Rotation().toRotationMatrix()};
    Mat3 tool, object;
    for (int c = 0; c < 3; ++c) {
      tool.col(c) = random.InCube(0.01);
      object.col(c) = candidate % 3 == 0 ? Vec3(object.col(0)) : random.InCube(0.01);
    }
    const TrianglePair pair{tool.data(),    object.data(),  at[0].p.data(),
                            at[1].p.data(), at[2].p.data(), random.Uniform(0.0, 0.01)};
    EightGaps gaps;
    for (auto& n : gaps.n) {
      for (int i = 0; i < 8; ++i) {
        const Vec3 direction = random.Direction();
        for (int c = 0; c < 3; ++c) n[c][i] = direction[c];
      }
    }
    for (int l = 0; l < levels; ++l) {
      EightGaps got = gaps;
      level[l]->find_gaps(pair, got);
      for (int end = 0; end < 2; ++end) {
        for (int i = 0; i < 8; ++i) {
          const Vec3 n(gaps.n[end][0][i], gaps.n[end][1][i], gaps.n[end][2][i]);
          const Vec3 down = -(at[end].R.transpose() * n), up = at[2].R.transpose() * n;
          const auto highest = [](const Mat3& x, const Vec3& m) {
            return std::max({m.dot(x.col(0)), m.dot(x.col(1)), m.dot(x.col(2))});
          };
          const double low = n.dot(at[end].p) - highest(tool, down) - pair.radius;
          ASSERT_EQ(got.gap[end][i], low - (n.dot(at[2].p) + highest(object, up)))
              << level[l]->name << ", candidate " << candidate;
        }
      }
    }
  }
}

TEST(Kernels, RefreshPlanesAtEverySimdLevel) {
  const Kernels* level[3];
  const int levels = AvailableKernels(level);
  Random random(15);
  constexpr int kSlots = 50;
  std::vector<PlaneRecord> records(kSlots);
  std::vector<std::uint32_t> epochs(kSlots);
  std::vector<EpochMotion> since(kPlaneEpochs);
  for (PlaneRecord& r : records) {
    const Vec3 n = random.Direction(), c = random.InCube(0.1);
    for (int k = 0; k < 3; ++k) {
      r.n[k] = n[k];
      r.centre[k] = c[k];
    }
    r.slack = random.Uniform(-1e-3, 1e-2);
    r.radius = random.Uniform(0.0, 0.02);
  }
  for (std::uint32_t& e : epochs) e = static_cast<std::uint32_t>(random.Below(1000));
  for (EpochMotion& m : since) {
    for (auto& row : m.row) {
      for (double& x : row) x = random.Uniform(-0.1, 0.1);
    }
  }
  const Mat3 R = random.Rotation().toRotationMatrix();
  const Mat3 rows = R.transpose();
  for (int count = 0; count <= 33; ++count) {
    std::vector<std::int32_t> slots;
    for (int i = 0; i < count; ++i) slots.push_back(random.Below(kSlots));
    std::vector<AlignedColumn> first_level;
    for (int k = 0; k < levels; ++k) {
      constexpr int kFirst = 3;
      std::vector<AlignedColumn> column(8, AlignedColumn(count + kFirst + 8));
      PlaneColumns planes{};
      for (int c = 0; c < 6; ++c) planes.along[c] = column[static_cast<std::size_t>(c)].data();
      planes.slack = column[6].data();
      planes.radius = column[7].data();
      level[k]->refresh_planes(records.data(), epochs.data(), slots.data(), count, since.data(),
                               rows.data(), kFirst, planes);
      for (int i = 0; i < count; ++i) {
        const auto slot = static_cast<std::size_t>(slots[static_cast<std::size_t>(i)]);
        const PlaneRecord& r = records[slot];
        const EpochMotion& m = since[epochs[slot] % kPlaneEpochs];
        const Vec3 n = Vec3::Map(r.n), c = Vec3::Map(r.centre), l = R * c;
        double slack = r.slack;
        Vec3 turned = Vec3::Zero();
        for (int a = 0; a < 3; ++a) {
          slack += n[a] * (Vec3::Map(m.row[a]).dot(c) + m.row[a][3]);
          turned += n[a] * Vec3::Map(m.row[a]);
        }
        slack -= turned.norm() * r.radius;
        ASSERT_NEAR(planes.slack[kFirst + i], slack, 1e-15);
        ASSERT_EQ(planes.radius[kFirst + i], r.radius);
        for (int a = 0; a < 3; ++a) {
          ASSERT_EQ(planes.along[a][kFirst + i], n[a]);
          ASSERT_NEAR(planes.along[3 + a][kFirst + i], l.cross(n)[a], 1e-15);
        }
        for (std::size_t c8 = 0; k > 0 && c8 < 8; ++c8) {
          ASSERT_EQ(column[c8].data()[kFirst + i], first_level[c8].data()[kFirst + i])
              << level[k]->name;
        }
      }
      if (k == 0) first_level = std::move(column);
    }
  }
}

// Where rounding decides, all levels must decide alike.
TEST(Kernels, AgreeWhereAPlaneIsUsedUpToTheLastBit) {
  const Kernels* level[3];
  const int levels = AvailableKernels(level);
  Random random(14);
  for (int candidate = 0; candidate < 2000; ++candidate) {
    std::vector<AlignedColumn> column(9, AlignedColumn(8));
    PlaneColumns planes{};
    for (int c = 0; c < 6; ++c) planes.along[c] = column[static_cast<std::size_t>(c)].data();
    planes.slack = column[6].data();
    planes.radius = column[7].data();
    planes.left = column[8].data();
    PlaneMotion motion{{}, -1.0, random.Uniform(0.0, 1e-3)};
    for (double& s : motion.step) s = random.Uniform(-1e-3, 1e-3);
    for (int i = 0; i < 8; ++i) {
      planes.radius[i] = random.Uniform(0.0, 0.05);
      for (int c = 0; c < 6; ++c) planes.along[c][i] = random.Uniform(-1.0, 1.0);
      double left = -TurnedOf(planes, i, motion) * planes.radius[i];
      for (int c = 0; c < 6; ++c) left += planes.along[c][i] * motion.step[c];
      planes.slack[i] = motion.least_new - left;  // to a few ulp
    }
    std::vector<std::int32_t> want;
    for (int k = 0; k < levels; ++k) {
      std::vector<std::int32_t> got(16, -1);
      const int found = level[k]->find_used_up(planes, 0, 8, motion, got.data());
      got.resize(static_cast<std::size_t>(found));
      if (k == 0) want = got;
      ASSERT_EQ(got, want) << level[k]->name << ", candidate " << candidate;
    }
  }
}

}  // namespace
}  // namespace palpate
