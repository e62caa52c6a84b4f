#include "server/physics/solve/response.h"

#include <cmath>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

using test::Random;

/// The chapter's angles (gamma, beta, alpha) about x, y, z of a rotation matrix, eq. 2.22 inverted.
Vec3 EulerAngles(const Mat3& R) {
  return {std::atan2(R(2, 1), R(2, 2)), std::asin(-R(2, 0)), std::atan2(R(1, 0), R(0, 0))};
}

TEST(Response, RotationVectorAgreesWithTheChaptersEulerAnglesToSecondOrder) {
  Random random(31);
  for (int i = 0; i < 1000; ++i) {
    const double angle = std::pow(10.0, random.Uniform(-4.0, -1.0));
    const Vec3 phi = angle * random.Direction();
    const Vec3 euler = EulerAngles(RotationExp(phi).toRotationMatrix());
    EXPECT_LT((euler - phi).norm(), angle * angle);
  }
}

TEST(Response, IsTheSpringOfTheChapter) {
  Random random(32);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 p_G = random.InCube(0.1), p_H = random.InCube(0.1);
    const Quat q_G = random.Rotation();
    const Quat q_H = RotationExp(random.Uniform(0.0, 3.0) * random.Direction()) * q_G;
    const Target target = TargetOf(p_G, q_G, p_H, q_H);
    const Wrench wrench = SpringWrench(target, Vec3::Zero(), Vec3::Zero(), 1000.0, 1.0);
    EXPECT_LT((wrench.force - 1000.0 * (p_G - p_H)).norm(), 1e-9);  // 2.20
    const Eigen::AngleAxisd relative(q_G * q_H.conjugate());        // 2.21
    EXPECT_LT((wrench.torque - relative.angle() * relative.axis()).norm(), 1e-9);
  }
}

TEST(Response, IsZeroWhereTheStepReachesTheTarget) {
  Random random(33);
  for (int i = 0; i < 100; ++i) {
    const Target target{random.InCube(0.1), 3.0 * random.Direction()};
    const Wrench wrench = SpringWrench(target, target.v, target.phi, 1000.0, 1.0);
    EXPECT_EQ(wrench.force.norm(), 0.0);
    EXPECT_LT(wrench.torque.norm(), 1e-15);
  }
}

}  // namespace
}  // namespace palpate
