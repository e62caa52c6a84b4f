#include "devices/scripted/scripted_device.h"

#include <gtest/gtest.h>

#include "tests/devices/limiter_support.h"

namespace palpate {
namespace {

TEST(ScriptedDevice, PlaysItsScriptExactlyWhateverTheForce) {
  Pose there;
  there.p = Vec3(0.1, 0.0, 0.0);
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
