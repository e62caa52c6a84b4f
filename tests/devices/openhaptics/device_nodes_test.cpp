#include "devices/openhaptics/device_nodes.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace palpate {
namespace {

using testing::HasSubstr;

class DeviceNodes : public testing::Test {
 protected:
  DeviceNodes() {
    std::string pattern = testing::TempDir() + "palpate-nodes-XXXXXX";
    folder = mkdtemp(pattern.data());
  }
  ~DeviceNodes() override { std::filesystem::remove_all(folder); }
  void Add(const std::string& name) { std::ofstream(folder + "/" + name) << "."; }
  std::string folder;
};

TEST_F(DeviceNodes, SayThatNothingIsPluggedIn) {
  Add("tty0");
  EXPECT_THAT(DescribeDeviceNodes(folder), HasSubstr("no arm is plugged in"));
  EXPECT_THAT(DescribeDeviceNodes(folder + "/none"), HasSubstr("no arm is plugged in"));
}

TEST_F(DeviceNodes, NameThoseThatTheUserMayNotOpen) {
  Add("ttyACM0");
  Add("fw0");
  const std::string text =
      DescribeDeviceNodes(folder, [](const std::string& node) { return node.ends_with("fw0"); });
  EXPECT_THAT(text, HasSubstr("may not open " + folder + "/ttyACM0: add it to the group"));
  EXPECT_THAT(DescribeDeviceNodes(folder),
              HasSubstr("may be opened: " + folder + "/fw0 " + folder + "/ttyACM0"));
}

}  // namespace
}  // namespace palpate
