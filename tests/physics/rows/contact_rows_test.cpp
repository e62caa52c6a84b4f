#include "server/physics/rows/contact_rows.h"

#include <vector>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

using test::Random;

TEST(ContactRows, AreTheDerivativeOfTheGap) {
  Random random(41);
  for (int candidate = 0; candidate < 200; ++candidate) {
    const Vec3 lever_T = random.InCube(0.05), c_O = random.InCube(0.05), p = random.InCube(0.05);
    const Quat q = random.Rotation();
    const LeafSphere tool{lever_T.x(), lever_T.y(), lever_T.z(), 0.003};
    const LeafSphere object{c_O.x(), c_O.y(), c_O.z(), 0.002};
    const double rho = 0.0316;
    ContactRows rows(16, rho);
    const NodePair pair{0, 0};
    ASSERT_TRUE(rows.Add(ActiveKernels(), &tool, &object, q.toRotationMatrix(), p, &pair, 1));
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

TEST(ContactRows, TakeABatchWhollyOrNotAtAll) {
  const LeafSphere tool{0.0, 0.0, 0.0, 0.001};
  const std::vector<LeafSphere> object(40, {0.01, 0.0, 0.0, 0.001});
  std::vector<NodePair> pairs;
  for (int i = 0; i < 40; ++i) pairs.push_back({0, i});
  ContactRows rows(32, 0.03);
  const auto add = [&](int from, int count) {
    return rows.Add(ActiveKernels(), &tool, object.data(), Mat3::Identity(), Vec3::Zero(),
                    pairs.data() + from, count);
  };
  EXPECT_TRUE(add(0, 30));
  EXPECT_FALSE(add(30, 3));
  EXPECT_EQ(rows.count(), 30);
  EXPECT_TRUE(add(30, 2));
  rows.Finish();
  for (int i = 0; i < 32; ++i) EXPECT_EQ(rows.id(i).b, i);
  rows.Clear();
  EXPECT_TRUE(add(8, 32));
}

TEST(ContactRows, GiveConcentricSpheresANormal) {
  const LeafSphere ball{0.0, 0.0, 0.0, 0.01};
  ContactRows rows(16, 0.03);
  const NodePair pair{0, 0};
  ASSERT_TRUE(rows.Add(ActiveKernels(), &ball, &ball, Mat3::Identity(), Vec3::Zero(), &pair, 1));
  EXPECT_EQ(rows.normal(0), Vec3::UnitZ());
  EXPECT_DOUBLE_EQ(rows.gap(0), -0.02);
}

TEST(ContactRows, FindRowsByTheirLeaves) {
  std::vector<LeafSphere> tool(3, {0.0, 0.0, 0.0, 0.001}), object(3, {0.01, 0.0, 0.0, 0.001});
  const std::vector<NodePair> pairs{{0, 1}, {2, 1}, {1, 2}};
  ContactRows rows(16, 0.03);
  ASSERT_TRUE(rows.Add(ActiveKernels(), tool.data(), object.data(), Mat3::Identity(), Vec3::Zero(),
                       pairs.data(), 3));
  constexpr std::int32_t kLeaves = ContactId::kLeaves;
  const ContactId wanted[] = {{kLeaves, 1, 2}, {kLeaves, 0, 0}, {kLeaves, 0, 1}, {0, 2, 1}};
  int row[4];
  ASSERT_EQ(rows.Find(wanted, row), 2);
  EXPECT_EQ(row[0], 2);
  EXPECT_EQ(row[1], 0);
}

}  // namespace
}  // namespace palpate
