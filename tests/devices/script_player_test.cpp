#include "devices/script_player.h"

#include <algorithm>

#include <gtest/gtest.h>

#include "common/math/rotation.h"
#include "devices/scripted/scripted_device.h"
#include "tests/devices/limiter_support.h"

namespace palpate {
namespace {

PoseScript OneWay() {
  const Pose there{Vec3(0.2, 0.1, 0.0), RotationExp(Vec3(0.0, 0.0, 1.0))};
  return PoseScript({{0.0, Pose{}, "go"}, {1.0, there, "stay"}});
}

TEST(ScriptPlayer, HoldsTheLastPoseWhenPlayedOnce) {
  const ScriptPlayer player(OneWay(), false);
  EXPECT_EQ(player.At(100.0).p, Vec3(0.2, 0.1, 0.0));
  EXPECT_EQ(player.VelocityAt(100.0).v, Vec3::Zero());
  EXPECT_STREQ(player.LabelAt(100.0), "stay");
}

TEST(ScriptPlayer, RepeatsWithoutAJump) {
  const ScriptPlayer player(OneWay(), true);
  double fastest = 0.0, fastest_turn = 0.0;
  for (int ms = 1; ms < 20000; ++ms) {
    const Pose before = player.At((ms - 1) * 1e-3);
    const Pose now = player.At(ms * 1e-3);
    fastest = std::max(fastest, (now.p - before.p).norm() / 1e-3);
    fastest_turn = std::max(fastest_turn, RotationLog(now.q * before.q.conjugate()).norm() / 1e-3);
  }
  EXPECT_LT(fastest, 0.5);  // on the way out: 0.22 m in 1 s, times 1.875
  EXPECT_LT(fastest_turn, 3.0);
  EXPECT_STREQ(player.LabelAt(1.5), "return");
}

TEST(ScriptPlayer, GivesTheVelocityOfItsPoses) {
  // Minimum jerk: in the middle of 1 s, speed and turn rate are 1.875 times their means.
  const ScriptPlayer player(OneWay(), false);
  const Twist middle = player.VelocityAt(0.5);
  EXPECT_NEAR(middle.v.x(), 1.875 * 0.2, 1e-5);
  EXPECT_NEAR(middle.w.z(), 1.875 * 1.0, 1e-5);
}

TEST(ScriptedDevice, PlaysItsScriptExactlyWhateverTheForce) {
  const Pose there{Vec3(0.1, 0.0, 0.0), Quat::Identity()};
  const PoseScript script({{0.0, Pose{}, "go"}, {1.0, there, "stay"}});
  ScriptedDevice device(ScriptPlayer(script, false));
  const LimitedWrench push = PassThrough({Vec3(10, 10, 10), Vec3(1, 1, 1)});
  for (int ms = 0; ms < 1500; ++ms) {
    const DeviceSample sample = device.Read();
    ASSERT_EQ(sample.X_WH.p, script.At(1e-3 * ms).p);
    ASSERT_STREQ(device.activity(), ms < 1000 ? "go" : "stay");
    device.Apply(push);
  }
  EXPECT_TRUE(device.Read().status & kDeviceForcesIgnored);
}

}  // namespace
}  // namespace palpate
