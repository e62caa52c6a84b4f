#include "devices/device_factory.h"

#include <gtest/gtest.h>

#include "common/error.h"

namespace palpate {
namespace {

PoseScript Still() {
  Pose at;
  at.p = Vec3(0.0, 0.0, 0.1);
  return PoseScript({{0.0, at, "hold"}, {1.0, at, "hold"}});
}

std::string MessageOf(const std::string& name) {
  try {
    MakeDevice({name, Still(), false});
  } catch (const UsageError& error) {
    return error.what();
  }
  return "";
}

TEST(DeviceFactory, MakesWhatItNames) {
  EXPECT_EQ(DeviceNames(), "simulated, scripted, openhaptics, mouse");
  for (const char* name : {"simulated", "scripted"}) {
    const auto device = MakeDevice({name, Still(), false});
    EXPECT_NE(device->info().model.find(name), std::string::npos);
    EXPECT_NEAR(device->Read().X_WH.p.z(), 0.1, 1e-9);
    EXPECT_STREQ(device->activity(), "hold");
  }
}

TEST(DeviceFactory, SaysWhichDevicesThisVersionLacks) {
  EXPECT_EQ(MessageOf("spacemouse"),
            "--device spacemouse: not built into this version; have: simulated, scripted, "
            "openhaptics, mouse");
  EXPECT_EQ(MessageOf("omega"),
            "--device omega: no such device; have: simulated, scripted, openhaptics, mouse");
}

TEST(DeviceFactory, AsksForAScriptWhereItNeedsOne) {
  EXPECT_TRUE(DeviceNeedsScript("simulated"));
  EXPECT_THROW(MakeDevice({"simulated", std::nullopt, false}), Error);
}

}  // namespace
}  // namespace palpate
