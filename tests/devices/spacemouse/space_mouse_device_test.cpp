#include "devices/spacemouse/space_mouse_device.h"

#include <chrono>
#include <functional>

#include <gtest/gtest.h>

#include "tests/devices/limiter_support.h"
#include "tests/devices/spacemouse/fake_spacenavd.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/eventually.h"

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

class SpaceMouseDeviceTest : public testing::Test {
 protected:
  SpaceMouseDeviceTest() : device_(Pose{Vec3(0, 0, 0.1), Quat::Identity()}) {}

  /// One tick in free space or, with `wall_`, with the graphic tool stopped at x = 0.
  void Tick() {
    sample_ = device_.Read();
    Pose X_WG = sample_.X_WH;
    if (wall_) X_WG.p.x() = std::min(0.0, X_WG.p.x());
    device_.SeeGraphicTool(X_WG, Vec3::Zero());
    device_.Apply(PassThrough({}));
  }
  /// Pushes the cap until `is_so`, ticking meanwhile: an event takes a while to come through.
  bool PushUntil(const std::array<int, 6>& axes, const std::function<bool()>& is_so) {
    for (int i = 0; i < 20'000; ++i) {
      if (i % 16 == 0) daemon_.Push(axes);
      Tick();
      if (is_so()) return true;
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
    return false;
  }
  bool TickUntil(const std::function<bool()>& is_so) {
    return test::Eventually([&] {
      Tick();
      return is_so();
    });
  }

  /// Pushes the cap, then presses a button: once the button is seen, the push has come through too.
  /// Without a graphic tool.  `holds` is checked after each tick.
  void PushUnseen(const std::array<int, 6>& axes, const std::function<bool()>& holds) {
    const auto tick = [&] {
      sample_ = device_.Read();
      device_.Apply(PassThrough({}));
      ASSERT_TRUE(holds()) << sample_.X_WH.p;
    };
    for (unsigned button = 0; button < 8; ++button) {
      daemon_.Push(axes);
      daemon_.Press(static_cast<int>(button), true);
      for (int i = 0; i < 20'000 && (sample_.buttons >> button & 1u) == 0; ++i) {
        ASSERT_NO_FATAL_FAILURE(tick());
        std::this_thread::sleep_for(std::chrono::microseconds(100));
      }
      ASSERT_EQ(sample_.buttons, (2u << button) - 1u);
      for (int i = 0; i < 16; ++i) ASSERT_NO_FATAL_FAILURE(tick());
    }
  }

  static constexpr std::array<int, 6> kRight{350}, kLeft{-350};
  test::FakeSpacenavd daemon_;
  SpaceMouseDevice device_;
  DeviceSample sample_;
  bool wall_ = false;
};

TEST_F(SpaceMouseDeviceTest, SaysThatItRendersNoForceAndStandsStillUntilItIsPushed) {
  for (int i = 0; i < 500; ++i) Tick();
  EXPECT_EQ(sample_.X_WH.p, Vec3(0, 0, 0.1));
  EXPECT_EQ(sample_.status, kDeviceForcesIgnored);
  EXPECT_STREQ(device_.activity(), "rests");
  EXPECT_EQ(device_.info().model, "SpaceMouse (Fake Navigator)");
}

TEST_F(SpaceMouseDeviceTest, MovesAsFastAsItIsPushed) {
  EXPECT_TRUE(PushUntil(kRight, [&] { return sample_.X_WH.p.x() > 0.05; }));
  EXPECT_NEAR(sample_.V_WH.v.x(), RateControl::kTopSpeed_m_s, 0.01);
  EXPECT_STREQ(device_.activity(), "moves");
  EXPECT_TRUE(PushUntil({0, 0, 0, 0, 350, 0}, [&] { return sample_.V_WH.w.y() > 1.4; }));
}

TEST_F(SpaceMouseDeviceTest, StandsStillUntilThereIsAGraphicTool) {
  ASSERT_NO_FATAL_FAILURE(PushUnseen({350, 350, 350, 350, 350, 350},
                                     [&] { return sample_.X_WH.p == Vec3(0, 0, 0.1); }));
  EXPECT_TRUE(PushUntil(kRight, [&] { return sample_.X_WH.p.x() > 0.001; }));
}

TEST_F(SpaceMouseDeviceTest, PressesNoDeeperThanItMayAndComesBackAtOnce) {
  wall_ = true;
  ASSERT_TRUE(PushUntil(kRight, [&] { return sample_.X_WH.p.x() > 0.0195; }));
  for (int i = 0; i < 2000; ++i) {
    if (i % 16 == 0) daemon_.Push(kRight);
    Tick();
    ASSERT_LE(sample_.X_WH.p.x(), BlindHand::kMaxPress_m + 1e-9);
  }
  // However long it was pushed against the wall, it comes back at once: 20 mm take 0.1 s.
  int ticks = 0;
  ASSERT_TRUE(PushUntil(kLeft, [&] {
    ticks += sample_.V_WH.v.x() < 0.0;
    return sample_.X_WH.p.x() < 0.0;
  }));
  EXPECT_LT(ticks, 250);
}

TEST_F(SpaceMouseDeviceTest, DoesNotPressOnWhenItsSessionEnds) {
  wall_ = true;
  ASSERT_TRUE(PushUntil(kRight, [&] { return sample_.X_WH.p.x() > 0.0195; }));
  device_.LoseGraphicTool();
  // It goes no further than where the graphic tool was.
  ASSERT_NO_FATAL_FAILURE(PushUnseen(kRight, [&] { return sample_.X_WH.p.x() <= 1e-9; }));
  EXPECT_TRUE(PushUntil(kRight, [&] { return sample_.X_WH.p.x() > 0.0195; }));
}

TEST_F(SpaceMouseDeviceTest, StandsStillWithAFaultWhileTheDaemonIsGoneAndResumes) {
  ASSERT_TRUE(PushUntil(kRight, [&] { return sample_.V_WH.v.x() > 0.1; }));
  daemon_.Kill();
  ASSERT_TRUE(TickUntil([&] { return (sample_.status & kDeviceFault) != 0; }));
  EXPECT_STREQ(device_.activity(), "stopped: spacenavd has ended");
  for (int i = 0; i < 1000; ++i) Tick();
  const Vec3 rest = sample_.X_WH.p;
  EXPECT_LT(sample_.V_WH.v.norm(), 1e-6);
  daemon_.Start();
  ASSERT_TRUE(TickUntil([&] { return (sample_.status & kDeviceFault) == 0; }));
  EXPECT_LT((sample_.X_WH.p - rest).norm(), 1e-6);
  EXPECT_TRUE(PushUntil(kLeft, [&] { return sample_.V_WH.v.x() < -0.1; }));
}

TEST_F(SpaceMouseDeviceTest, StopsWhereADaemonHangsInTheMiddleOfAPush) {
  ASSERT_TRUE(PushUntil(kRight, [&] { return sample_.V_WH.v.x() > 0.1; }));
  for (int i = 0; i < 1000; ++i) Tick();  // a second in which nothing comes
  EXPECT_LT(sample_.V_WH.v.norm(), 1e-6);
  EXPECT_EQ(sample_.status, kDeviceForcesIgnored);
}

TEST_F(SpaceMouseDeviceTest, TellsItsButtons) {
  daemon_.Press(1, true);
  EXPECT_TRUE(TickUntil([&] { return sample_.buttons == 2; }));
  daemon_.Press(1, false);
  EXPECT_TRUE(TickUntil([&] { return sample_.buttons == 0; }));
}

TEST_F(SpaceMouseDeviceTest, AllocatesNothingInTheLoop) {
  const LimitedWrench nothing = PassThrough({});
  daemon_.Push(kRight);
  const std::uint64_t before = test::AllocationsOfThisThread();
  for (int i = 0; i < 100; ++i) {
    device_.SeeGraphicTool(device_.Read().X_WH, Vec3::Zero());
    device_.Apply(nothing);
    device_.activity();
  }
  EXPECT_EQ(test::AllocationsOfThisThread(), before);
}

}  // namespace
}  // namespace palpate
