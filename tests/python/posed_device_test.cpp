#include "client/python/live/posed_device.h"

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "devices/blind_hand.h"
#include "devices/wrench_limiter.h"

namespace palpate::test {
namespace {

const Pose kStart{Vec3(0.1, 0.2, 0.3), Quat::Identity()};

/// The device with a limiter, driven as by a loop.
struct Loop {
  PosedDevice device{kStart, 20.0, 2.0};
  WrenchLimiter limiter{WrenchLimits::Of(device.info())};

  DeviceSample Tick(Wrench contact = {}) {
    const DeviceSample sample = device.Read();
    Wrench led;
    device.Shape(contact, led);
    device.Apply(limiter.Limit({}));
    return sample;
  }
};

TEST(PosedDevice, RestsUntilItIsMoved) {
  Loop loop;
  for (int i = 0; i < 10; ++i) {
    const DeviceSample sample = loop.Tick();
    EXPECT_EQ(sample.X_WH.p, kStart.p);
    EXPECT_TRUE(sample.V_WH.v.isZero(0.0));
    EXPECT_EQ(sample.status, kDeviceForcesIgnored);
  }
  EXPECT_EQ(loop.device.felt().move, 0u);
}

TEST(PosedDevice, TakesTheTimeThatItIsGivenAtOneSpeedAndArrivesToTheBit) {
  Loop loop;
  const Pose X_WT{kStart.p + Vec3(0.01, 0.0, -0.02), RotationExp(Vec3(0.0, 0.1, 0.0))};
  EXPECT_EQ(loop.device.Go(X_WT, 0.1), 1u);
  Pose before = kStart;
  for (int tick = 1; tick <= 100; ++tick) {
    EXPECT_EQ(loop.device.felt().move, 0u) << "arrived in tick " << tick - 1;
    const DeviceSample sample = loop.Tick();
    EXPECT_NEAR((sample.X_WH.p - before.p - 1e-3 * sample.V_WH.v).norm(), 0.0, 1e-12);
    EXPECT_NEAR(sample.V_WH.w.y(), 1.0, 1e-9);
    before = sample.X_WH;
  }
  const Felt felt = loop.device.felt();
  EXPECT_EQ(felt.move, 1u);
  EXPECT_GT(felt.arrived_ns, 0);
  EXPECT_EQ(felt.X_WH.p, X_WT.p);
  EXPECT_EQ(felt.X_WH.q.coeffs(), X_WT.q.coeffs());
  EXPECT_TRUE(loop.Tick().V_WH.v.isZero(0.0));
}

TEST(PosedDevice, IsNoFasterThanAHandWhateverItIsTold) {
  Loop loop;
  loop.device.Go({kStart.p + Vec3(0.05, 0.0, 0.0), Quat::Identity()}, 0.0);
  int ticks = 0;
  for (; loop.device.felt().move == 0; ++ticks) {
    EXPECT_LE(loop.Tick().V_WH.v.norm(), BlindHand::kMaxSpeed_m_s + 1e-12);
  }
  EXPECT_EQ(ticks, 100);
  loop.device.Go({kStart.p, RotationExp(Vec3(0.0, 0.0, 3.0))}, 0.0);
  while (loop.device.felt().move == 1) {
    EXPECT_LE(loop.Tick().V_WH.w.norm(), BlindHand::kMaxTurn_rad_s + 1e-9);
  }
}

TEST(PosedDevice, TurnsFromAMoveUnderWayToTheNextWithoutAJump) {
  Loop loop;
  loop.device.Go({kStart.p + Vec3(0.05, 0.0, 0.0), Quat::Identity()}, 1.0);
  for (int i = 0; i < 500; ++i) loop.Tick();
  const Vec3 middle = loop.device.felt().X_WH.p;
  EXPECT_NEAR(middle.x(), kStart.p.x() + 0.025, 1e-9);
  EXPECT_EQ(loop.device.Go(kStart, 0.1), 2u);
  EXPECT_LT((loop.Tick().X_WH.p - middle).norm(), 0.0005);
  for (int i = 1; i < 100; ++i) loop.Tick();
  EXPECT_EQ(loop.device.felt().move, 2u) << "the first is never said to have arrived";
  EXPECT_EQ(loop.device.felt().X_WH.p, kStart.p);
}

TEST(PosedDevice, TellsWhatWasWantedAndWhatTheLimiterLetThrough) {
  Loop loop;
  loop.Tick({Vec3(0.0, 3.0, 0.0), Vec3::Zero()});
  EXPECT_EQ(loop.device.felt().wanted.force.y(), 3.0);
  EXPECT_TRUE(loop.device.felt().applied.force.isZero(0.0));  // the limiter was asked for no force
  EXPECT_FALSE(loop.device.felt().sees_tool);
  loop.device.SeeGraphicTool(kStart, Vec3::Zero());
  loop.Tick();
  EXPECT_TRUE(loop.device.felt().sees_tool);
  loop.device.LoseGraphicTool();
  loop.Tick();
  EXPECT_FALSE(loop.device.felt().sees_tool);
}

TEST(PosedDevice, IsLedWithinBoundsAndNoLongerThanSomebodySaysSo) {
  Loop loop;
  HeldWrench held{.wrench = {Vec3(0.0, 0.5, 0.0), Vec3::Zero()}, .X_WH = kStart, .every = 20};
  held.stiffness(0, 0) = 100.0;
  held.stiffness(5, 5) = 0.1;
  loop.device.Lead(held);
  loop.Tick();
  EXPECT_EQ(loop.device.felt().wanted.force, Vec3(0.0, 0.5, 0.0));
  loop.device.Go({kStart.p + Vec3(0.005, 0.0, 0.0), RotationExp(Vec3(0.0, 0.0, 0.05))}, 0.01);
  for (int i = 0; i < 10; ++i) loop.Tick();
  const Wrench pulls = loop.device.felt().wanted;
  EXPECT_TRUE(pulls.force.isApprox(Vec3(-0.5, 0.5, 0.0), 1e-9)) << pulls.force;
  EXPECT_TRUE(pulls.torque.isApprox(Vec3(0.0, 0.0, -0.005), 1e-9)) << pulls.torque;
  loop.device.Go({kStart.p + Vec3(1.0, 0.0, 0.0), Quat::Identity()}, 0.01);
  for (int i = 11; i < 80; ++i) loop.Tick();
  EXPECT_NEAR(loop.device.felt().wanted.force.norm(), 1.0, 1e-12);
  EXPECT_NEAR(loop.device.felt().V_WH.v.x(), BlindHand::kMaxSpeed_m_s, 1e-12);
  loop.Tick();
  EXPECT_TRUE(loop.device.felt().wanted.force.isZero(0.0)) << "four times as late as it should be";
}

}  // namespace
}  // namespace palpate::test
