#include "server/physics/rows/contact_rows.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

using test::Random;

TEST(ContactRows, AreTheDerivativeOfTheGap) {
  Random random(41);
  for (int trial = 0; trial < 200; ++trial) {
    const Vec3 lever_T = random.InCube(0.05), c_O = random.InCube(0.05), p = random.InCube(0.05);
    const Quat q = random.Rotation();
    const LeafSphere tool{lever_T.x(), lever_T.y(), lever_T.z(), 0.003};
    const LeafSphere object{c_O.x(), c_O.y(), c_O.z(), 0.002};
    const double rho = 0.0316;
    ContactRows rows(16, 64, 6, rho);
    const NodePair pair{0, 0};
    rows.Add(ActiveKernels(), &tool, &object, q.toRotationMatrix(), p, &pair, 1);
    rows.Finish();
    ASSERT_EQ(rows.count(), 1);
    const auto gap = [&](const Vec3& v, const Vec3& phi) {
      return (p + v + RotationExp(phi) * (q * lever_T) - c_O).norm() - 0.005;
    };
    EXPECT_NEAR(rows.gap(0), gap(Vec3::Zero(), Vec3::Zero()), 1e-15);
    const double h = 1e-6;
    for (int i = 0; i < 3; ++i) {
      const Vec3 e = h * Vec3::Unit(i);
      const Vec3 zero = Vec3::Zero();
      EXPECT_NEAR(rows.normal(0)[i], (gap(e, zero) - gap(-e, zero)) / (2 * h), 1e-8);
      EXPECT_NEAR(rows.lever_cross_normal(0)[i], (gap(zero, e) - gap(zero, -e)) / (2 * h), 1e-8);
      EXPECT_NEAR(rows.view().a[3 + i][0] * rho, rows.lever_cross_normal(0)[i], 1e-15);
    }
  }
}

TEST(ContactRows, KeepTheTightestAndSaySoWhenFull) {
  Random random(42);
  std::vector<LeafSphere> tool{{0.0, 0.0, 0.0, 0.001}};
  std::vector<LeafSphere> object;
  std::vector<NodePair> pairs;
  for (int i = 0; i < 500; ++i) {
    object.push_back({random.Uniform(0.01, 0.02), 0.0, 0.0, 0.001});
    pairs.push_back({0, i});
  }
  ContactRows rows(64, 512, 6, 0.03);
  rows.Add(ActiveKernels(), tool.data(), object.data(), Mat3::Identity(), Vec3::Zero(),
           pairs.data(), 300);
  rows.Add(ActiveKernels(), tool.data(), object.data(), Mat3::Identity(), Vec3::Zero(),
           pairs.data() + 300, 200);
  rows.Finish();
  EXPECT_TRUE(rows.overflowed());
  ASSERT_EQ(rows.count(), 64);
  std::vector<double> gaps;
  for (const LeafSphere& leaf : object) gaps.push_back(leaf.x - 0.002);
  std::sort(gaps.begin(), gaps.end());
  std::vector<double> kept;
  for (int i = 0; i < 64; ++i) {
    kept.push_back(rows.gap(i));
    if (i > 0) {
      EXPECT_LT(rows.id(i - 1).object, rows.id(i).object);
    }
  }
  std::sort(kept.begin(), kept.end());
  for (std::size_t i = 0; i < 64; ++i) EXPECT_NEAR(kept[i], gaps[i], 1e-15);
  rows.Clear();
  EXPECT_FALSE(rows.overflowed());
}

TEST(ContactRows, AreTheSameHoweverManyBatchesBringThem) {
  // Many equal gaps, so that the order decides, and many more rows than fit.
  Random random(43);
  std::vector<LeafSphere> tool{{0.0, 0.0, 0.0, 0.001}};
  std::vector<LeafSphere> object;
  std::vector<NodePair> pairs;
  for (int i = 0; i < 4000; ++i) {
    object.push_back({0.01 + 1e-4 * random.Below(40), 0.0, 0.0, 0.001});
    pairs.push_back({0, i});
  }
  // The reference: the first 64 of a stable sort by gap, in their original order.
  std::vector<int> expected(4000);
  std::iota(expected.begin(), expected.end(), 0);
  std::stable_sort(expected.begin(), expected.end(), [&](int i, int j) {
    return object[static_cast<std::size_t>(i)].x < object[static_cast<std::size_t>(j)].x;
  });
  expected.resize(64);
  std::sort(expected.begin(), expected.end());
  for (const int batch : {1, 7, 64, 100, 256}) {
    ContactRows rows(64, 256, 6, 0.03);
    for (int round = 0; round < 2; ++round) {  // the second after Clear
      rows.Clear();
      for (int at = 0; at < 4000; at += batch) {
        rows.Add(ActiveKernels(), tool.data(), object.data(), Mat3::Identity(), Vec3::Zero(),
                 pairs.data() + at, std::min(batch, 4000 - at));
      }
      rows.Finish();
      EXPECT_TRUE(rows.overflowed());
      ASSERT_EQ(rows.count(), 64);
      for (int i = 0; i < 64; ++i) {
        EXPECT_EQ(rows.id(i).object, expected[static_cast<std::size_t>(i)]) << batch;
        EXPECT_NEAR(rows.gap(i), object[static_cast<std::size_t>(rows.id(i).object)].x - 0.002,
                    1e-15);
      }
    }
  }
}

TEST(ContactRows, GiveConcentricSpheresANormal) {
  const LeafSphere ball{0.0, 0.0, 0.0, 0.01};
  ContactRows rows(16, 64, 6, 0.03);
  const NodePair pair{0, 0};
  rows.Add(ActiveKernels(), &ball, &ball, Mat3::Identity(), Vec3::Zero(), &pair, 1);
  EXPECT_EQ(rows.normal(0), Vec3::UnitZ());
  EXPECT_DOUBLE_EQ(rows.gap(0), -0.02);
}

TEST(ContactRows, FindRowsByTheirLeaves) {
  std::vector<LeafSphere> tool(3, {0.0, 0.0, 0.0, 0.001}), object(3, {0.01, 0.0, 0.0, 0.001});
  const std::vector<NodePair> pairs{{0, 1}, {2, 1}, {1, 2}};
  ContactRows rows(16, 64, 6, 0.03);
  rows.Add(ActiveKernels(), tool.data(), object.data(), Mat3::Identity(), Vec3::Zero(),
           pairs.data(), 3);
  constexpr std::int32_t kLeaves = ContactId::kLeaves;
  const ContactId wanted[] = {{kLeaves, 1, 2}, {kLeaves, 0, 0}, {kLeaves, 0, 1}, {0, 2, 1}};
  int row[4];
  ASSERT_EQ(rows.Find(wanted, row), 2);
  EXPECT_EQ(row[0], 2);
  EXPECT_EQ(row[1], 0);
}

}  // namespace
}  // namespace palpate
