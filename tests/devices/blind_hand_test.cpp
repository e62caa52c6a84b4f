#include "devices/blind_hand.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "tests/devices/limiter/limiter_figures.h"
#include "tests/support/random.h"

namespace palpate {
namespace {

using test::kTick;

Pose At(const Vec3& p, const Vec3& turned = Vec3::Zero()) {
  return {p, RotationExp(turned)};
}

/// Where a wall at x = 0 stops the tool, a point at p_HT that stays at x < 0.
Pose StoppedByWall(const Pose& X_WH, const Vec3& p_HT) {
  Pose X_WG = X_WH;
  X_WG.p.x() -= std::max(0.0, (X_WH * p_HT).x());
  return X_WG;
}

/// Lets time pass in front of the wall or, without `wall`, in free space.
void Pass(BlindHand& hand, const Vec3& p_HT, int ticks, bool wall = true) {
  for (int i = 0; i < ticks; ++i) {
    hand.SeeGraphicTool(wall ? StoppedByWall(hand.pose(), p_HT) : hand.pose(), p_HT);
    hand.Step(kTick);
    ASSERT_TRUE(!wall || hand.pose().p.x() <= BlindHand::kMaxPress_m + 1e-4);
  }
}

TEST(BlindHand, RestsUntilItIsToldOrSeesTheGraphicToolThatItIsDrivenFrom) {
  BlindHand hand(At(Vec3(1, 2, 3)));
  for (const bool driven : {false, true}) {
    if (driven) hand.Drive({Vec3(0.2, 0, 0), Vec3(0, 1, 0)});
    for (int i = 0; i < 1000; ++i) hand.Step(kTick);
    EXPECT_EQ(hand.pose().p, Vec3(1, 2, 3));
    EXPECT_EQ(hand.twist().v, Vec3::Zero());
  }
}

TEST(BlindHand, ComesToTheTargetAtBoundedSpeedAndDoesNotOvershoot) {
  const Pose target = At(Vec3(0.3, 0, 0), Vec3(0, 2.0, 0));
  BlindHand hand(At(Vec3::Zero()));
  hand.Follow(target);
  double x = 0.0, angle = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const Pose before = hand.pose();
    hand.Step(kTick);
    const double way = (hand.pose().p - before.p).norm();
    ASSERT_LE(way, BlindHand::kMaxSpeed_m_s * kTick * (1 + 1e-9));
    ASSERT_LE(RotationLog(hand.pose().q * before.q.conjugate()).norm(),
              BlindHand::kMaxTurn_rad_s * kTick * (1 + 1e-9));
    ASSERT_GE(hand.pose().p.x(), x);
    x = hand.pose().p.x();
    angle = RotationLog(hand.pose().q).y();
    ASSERT_LE(x, 0.3 + 1e-9);
    ASSERT_LE(angle, 2.0 + 1e-9);
  }
  EXPECT_NEAR(x, 0.3, 1e-6);
  EXPECT_NEAR(angle, 2.0, 1e-6);
}

TEST(BlindHand, TellsTheVelocityThatItMovesWith) {
  const Vec3 p_HT(0.05, 0.02, -0.01);
  BlindHand hand(At(Vec3::Zero()));
  hand.Follow(At(Vec3(0.1, -0.05, 0.02), Vec3(0.3, -0.5, 0.2)));
  for (int i = 0; i < 300; ++i) {
    hand.SeeGraphicTool(hand.pose(), p_HT);  // free
    const Pose before = hand.pose();
    hand.Step(kTick);
    const Vec3 v = (hand.pose().p - before.p) / kTick;
    ASSERT_LT((hand.twist().v - v).norm(), 1e-3 * (1.0 + v.norm()));
  }
}

TEST(BlindHand, NeverJumpsWhateverItIsTold) {
  test::Random random(11);
  const Vec3 p_HT(0.05, 0, 0);
  // The bounded speed is that of a point 50 mm from the handle's origin.
  const double most = kTick * (BlindHand::kMaxSpeed_m_s + 0.05 * BlindHand::kMaxTurn_rad_s);
  BlindHand hand(At(Vec3::Zero()));
  for (int i = 0; i < 50'000; ++i) {
    if (random.Below(16) == 0) {
      hand.Follow(At(random.InCube(10.0), random.InCube(3.0)));
    } else if (random.Below(50) == 0) {
      hand.LetGo();
    }
    if (random.Below(3) == 0) hand.SeeGraphicTool(At(random.InCube(1.0), random.InCube(3.0)), p_HT);
    const Pose before = hand.pose();
    hand.Step(kTick);
    ASSERT_LE((hand.pose().p - before.p).norm(), most * (1 + 1e-2));
    ASSERT_LE(RotationLog(hand.pose().q * before.q.conjugate()).norm(),
              BlindHand::kMaxTurn_rad_s * kTick * (1 + 1e-6));
    ASSERT_NEAR(hand.pose().q.norm(), 1.0, 1e-9);
  }
}

TEST(BlindHand, PressesNoDeeperThanItMayAndLetsGoOfTheForce) {
  const Vec3 p_HT(0.0, 0.03, 0.0);
  BlindHand hand(At(Vec3(-0.1, 0, 0)));
  hand.Follow(At(Vec3(0.4, 0, 0)));  // far inside
  Pass(hand, p_HT, 3000);
  EXPECT_TRUE(hand.held_back());
  EXPECT_NEAR(hand.pose().p.x(), BlindHand::kMaxPress_m, 1e-4);
  hand.LetGo();
  Pass(hand, p_HT, 1000);
  EXPECT_NEAR(hand.pose().p.x(), 0.0, 1e-6);
  EXPECT_FALSE(hand.held_back());
}

TEST(BlindHand, IsPutBackToTheGraphicToolWhereItsSessionEndsAndWaitsForTheNext) {
  const Vec3 p_HT(0.0, 0.03, 0.0);
  BlindHand hand(At(Vec3(-0.1, 0, 0)));
  hand.LoseGraphicTool();  // it has seen none yet: no effect
  hand.Follow(At(Vec3(0.4, 0, 0)));
  Pass(hand, p_HT, 3000);
  const Pose graphic = StoppedByWall(hand.pose(), p_HT);
  ASSERT_GT((hand.pose().p - graphic.p).norm(), 0.9 * BlindHand::kMaxPress_m);
  hand.LoseGraphicTool();
  for (int i = 0; i < 1000; ++i) {
    ASSERT_LT((hand.pose().p - graphic.p).norm(), 1e-3);
    ASSERT_EQ(hand.twist().v, Vec3::Zero());
    hand.Step(kTick);
  }
  EXPECT_FALSE(hand.held_back());
  Pass(hand, p_HT, 3000);  // the next session
  EXPECT_NEAR(hand.pose().p.x(), BlindHand::kMaxPress_m, 1e-4);
}

TEST(BlindHand, PressesNoMoreInTheNextSessionUnlessItIsDrivenThereAnew) {
  const Vec3 p_HT(0.0, 0.03, 0.0);
  BlindHand hand(At(Vec3(-0.01, 0, 0)));
  const auto step = [&](double v, int ticks) {
    hand.Drive({Vec3(v, 0, 0), Vec3::Zero()});
    Pass(hand, p_HT, ticks);
  };
  step(0.2, 1000);
  step(0.0, 1000);
  ASSERT_NEAR(hand.pose().p.x(), BlindHand::kMaxPress_m, 1e-6) << "let go, it stays where it is";
  hand.LoseGraphicTool();
  for (int i = 0; i < 1000; ++i) hand.Step(kTick);
  step(0.0, 1000);
  EXPECT_NEAR(hand.pose().p.x(), 0.0, 1e-6);
  step(0.2, 1000);
  EXPECT_NEAR(hand.pose().p.x(), BlindHand::kMaxPress_m, 1e-6);
}

TEST(BlindHand, TwistsAToolThatIsHeldNoFurtherThanItMay) {
  const Pose held = At(Vec3::Zero());
  BlindHand hand(held);
  hand.Follow(At(Vec3::Zero(), Vec3(0, 0, 3.0)));
  for (int i = 0; i < 3000; ++i) {
    hand.SeeGraphicTool(held, Vec3::Zero());
    hand.Step(kTick);
  }
  EXPECT_NEAR(RotationLog(hand.pose().q).z(), BlindHand::kMaxTwist_rad, 1e-6);
}

TEST(BlindHand, IsDrivenAtTheVelocityThatItIsTold) {
  const Vec3 p_HT(0.03, 0.0, 0.02);
  BlindHand hand(At(Vec3::Zero()));
  const Twist V{Vec3(0.1, -0.05, 0.02), Vec3(0.5, -0.3, 1.0)};
  hand.Drive(V);
  Pass(hand, p_HT, 1000, false);
  EXPECT_LT((hand.twist().v + hand.twist().w.cross(hand.pose().q * p_HT) - V.v).norm(), 1e-6);
  EXPECT_LT((hand.twist().w - V.w).norm(), 1e-6);
  hand.Drive({});
  Pass(hand, p_HT, 1000, false);
  EXPECT_LT(hand.twist().v.norm(), 1e-9);
}

TEST(BlindHand, IsDrivenBackFromAWallWithoutHavingToComeBackFirst) {
  const Vec3 p_HT(0.0, 0.03, 0.0);
  BlindHand hand(At(Vec3(-0.01, 0, 0)));
  hand.Drive({Vec3(0.2, 0, 0), Vec3::Zero()});
  Pass(hand, p_HT, 10'000);  // ten seconds against the wall: 2 m if nothing held it back
  EXPECT_TRUE(hand.held_back());
  EXPECT_NEAR(hand.pose().p.x(), BlindHand::kMaxPress_m, 1e-6);
  hand.Drive({Vec3(-0.2, 0, 0), Vec3::Zero()});
  Pass(hand, p_HT, 200);  // 20 mm at 0.2 m/s take 0.1 s, and the spring's lag 0.05 s
  EXPECT_LT(hand.pose().p.x(), 0.0);
}

}  // namespace
}  // namespace palpate
