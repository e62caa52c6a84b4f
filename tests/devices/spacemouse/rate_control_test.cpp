#include "devices/spacemouse/rate_control.h"

#include <cmath>

#include <gtest/gtest.h>

#include "devices/blind_hand.h"

namespace palpate {
namespace {

TEST(RateControl, IsStillInsideTheDeadBandAndAtTopSpeedAtFullDeflection) {
  for (int counts = -20; counts <= 20; ++counts) EXPECT_EQ(RateControl::Share(counts), 0.0);
  EXPECT_GT(RateControl::Share(21), 0.0);
  EXPECT_EQ(RateControl::Share(350), 1.0);
  EXPECT_EQ(RateControl::Share(-350), -1.0);
}

TEST(RateControl, GrowsWithoutAJumpAndIsOddAndBoundedWhateverItIsTold) {
  // The slope is steepest at the end: 2 / (350 - 20) per count.
  for (int counts = 0; counts < 1000; ++counts) {
    const double step = RateControl::Share(counts + 1) - RateControl::Share(counts);
    ASSERT_GE(step, 0.0);
    ASSERT_LE(step, 2.0 / 330.0);
    ASSERT_EQ(RateControl::Share(-counts), -RateControl::Share(counts));
  }
  EXPECT_EQ(RateControl::Share(INT32_MAX), 1.0);
  EXPECT_EQ(RateControl::Share(INT32_MIN), -1.0);
}

TEST(RateControl, TurnsSpacenavdsAxesIntoARightHandedFrame) {
  const Twist V = RateControl::Velocity({350, 350, 350, 350, 350, 350});
  EXPECT_EQ(V.v, RateControl::kTopSpeed_m_s * Vec3(1, 1, -1));
  EXPECT_EQ(V.w, RateControl::kTopTurn_rad_s * Vec3(1, 1, -1));
}

TEST(RateControl, AsksForNoMoreThanTheHandBehindItGives) {
  const Twist V = RateControl::Velocity({999, 999, 999, 999, 999, 999});
  EXPECT_LT(V.v.norm(), BlindHand::kMaxSpeed_m_s);
  EXPECT_LT(V.w.norm(), BlindHand::kMaxTurn_rad_s);
}

}  // namespace
}  // namespace palpate
