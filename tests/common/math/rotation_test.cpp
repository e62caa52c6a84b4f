#include "common/math/rotation.h"

#include <algorithm>
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
    // The shortest way turns about an axis perpendicular to both.
    EXPECT_NEAR(RotationLog(q).dot(from.normalized()), 0.0, 1e-7);
  }
}

TEST(Rotation, GoesOnPastHalfATurnAndBackTheSameWay) {
  Random random(73);
  for (int trial = 0; trial < 50; ++trial) {
    const Vec3 axis = random.Direction();
    Vec3 turn = Vec3::Zero();
    // Three turns forth and four back, in steps of up to 30 degrees.
    double angle = 0.0;
    for (const double goal : {6.0 * M_PI, -2.0 * M_PI}) {
      while (angle != goal) {
        const double step = random.Uniform(0.0, 0.5);
        angle = goal > angle ? std::min(angle + step, goal) : std::max(angle - step, goal);
        const Vec3 expected = std::clamp(angle, -2.0 * M_PI, 2.0 * M_PI) * axis;
        ASSERT_LT((RotationLogFrom(RotationExp(angle * axis), turn) - expected).norm(), 1e-12)
            << angle;
      }
    }
  }
}

TEST(Rotation, GoesOnAsSmoothlyAsTheHandTrembles) {
  Random random(74);
  const Vec3 axis = random.Direction();
  Vec3 turn = Vec3::Zero(), before = Vec3::Zero();
  for (int i = 0; i < 4000; ++i) {
    // To 700 degrees and back, trembling by up to 6 degrees about other axes.
    const double angle = (i < 2000 ? i : 4000 - i) * 0.35 * M_PI / 180.0;
    const Vec3 across =
        axis.cross(Vec3(std::sin(0.07 * i), std::cos(0.11 * i), std::sin(0.05 * i)));
    const Vec3 now = RotationLogFrom(RotationExp(0.1 * across) * RotationExp(angle * axis), turn);
    // On the way back past half a turn, what was cut off beyond it returns.
    ASSERT_LT((now - before).norm(), i > 2000 && std::fabs(angle - M_PI) < 0.2 ? 0.4 : 0.12) << i;
    ASSERT_LE(now.norm(), 2.0 * M_PI + 1e-12);
    ASSERT_TRUE(angle <= 0.3 || now.dot(axis) > 0.15) << i;
    before = now;
  }
}

TEST(Rotation, IsTheSameWhereNothingMoves) {
  // A function of rotation and axis alone: it does not creep, however often it is called.
  Vec3 turn = 3.2 * Vec3::UnitZ();
  const Quat q = RotationExp(Vec3(0.4, -0.2, 0.0)) * RotationExp(Vec3(0.0, 0.0, 5.5));
  const Vec3 first = RotationLogFrom(q, turn);
  for (int i = 0; i < 100; ++i) EXPECT_LT((RotationLogFrom(q, turn) - first).norm(), 1e-12);
}

TEST(Rotation, DifferencesAreLogarithmsUntilThoseTurnRound) {
  Random random(75);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 a = 1e-3 * random.Direction(), axis = random.Direction();
    const Vec3 near = 3.0 * axis;
    EXPECT_EQ(RotationDifference(a, near),
              RotationLog(RotationExp(a) * RotationExp(near).conjugate()));
    for (const double angle : {3.1415, 3.1417, 4.0, 6.2831}) {
      const Vec3 far = angle * axis;
      EXPECT_LT((RotationDifference(a, far) - (a - far)).norm(), 5e-3) << angle;
    }
  }
}

TEST(Rotation, ZeroIsTheIdentityToTheBit) {
  EXPECT_EQ(RotationExp(Vec3::Zero()).coeffs(), Quat::Identity().coeffs());
  EXPECT_EQ(RotationLog(Quat::Identity()), Vec3::Zero());
}

}  // namespace
}  // namespace palpate
