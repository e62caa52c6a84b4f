#include "common/math/rotation.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/random.h"

namespace palpate {
namespace {

using test::Random;

TEST(Rotation, ExpAndLogAgreeWithLibmAtAnyAngle) {
  Random random(71);
  for (int i = 0; i < 20000; ++i) {
    const double angle =
        i % 2 == 0 ? random.Uniform(0.0, 3.14159) : std::pow(10.0, random.Uniform(-12.0, 0.0));
    const Vec3 axis = random.Direction();
    const Quat q = RotationExp(angle * axis);
    EXPECT_NEAR(q.w(), std::cos(0.5 * angle), 1e-15);
    EXPECT_LT((q.vec() - std::sin(0.5 * angle) * axis).norm(), 1e-15);
    EXPECT_LT((RotationLog(q) - angle * axis).norm(), 4e-15 * std::max(1.0, angle));
  }
}

TEST(Rotation, LogTakesTheShorterWayRoundWhateverTheSign) {
  Random random(72);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 axis = random.Direction();
    const double angle = random.Uniform(3.1416, 6.28);
    const Quat q = RotationExp(angle * axis);
    const Quat minus(-q.w(), -q.x(), -q.y(), -q.z());
    const Vec3 shorter = (angle - 2.0 * 3.14159265358979324) * axis;
    EXPECT_LT((RotationLog(q) - shorter).norm(), 1e-14);
    EXPECT_LT((RotationLog(minus) - shorter).norm(), 1e-14);
  }
}

TEST(Rotation, ManyTurnsAreTheirRemainder) {
  const Vec3 axis = Vec3(1.0, 2.0, -2.0) / 3.0;
  const double turns = 1000.0 * 2.0 * 3.14159265358979324;
  const Vec3 left = RotationLog(RotationExp((turns + 0.25) * axis));
  EXPECT_LT((left - 0.25 * axis).norm(), 1e-11);
}

TEST(Rotation, BetweenTakesOneDirectionToTheOtherTheShortestWay) {
  Random random(73);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 from = random.Uniform(0.1, 9.0) * random.Direction();
    const Vec3 to = i % 3 == 0   ? Vec3(-2.0 * from)
                    : i % 3 == 1 ? Vec3(0.5 * from)
                                 : random.Direction();
    const Quat q = RotationBetween(from, to);
    EXPECT_NEAR(q.norm(), 1.0, 1e-14);
    EXPECT_LT((q * from.normalized() - to.normalized()).norm(), 1e-7);
    // The shortest way turns about an axis across both.
    EXPECT_NEAR(RotationLog(q).dot(from.normalized()), 0.0, 1e-7);
  }
}

TEST(Rotation, ZeroIsTheIdentityToTheBit) {
  EXPECT_EQ(RotationExp(Vec3::Zero()).coeffs(), Quat::Identity().coeffs());
  EXPECT_EQ(RotationLog(Quat::Identity()), Vec3::Zero());
}

}  // namespace
}  // namespace palpate
