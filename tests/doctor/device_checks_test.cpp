#include "client/doctor/device_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/error.h"
#include "tests/doctor/made_up_host.h"

namespace palpate::doctor {
namespace {

using testing::HasSubstr;
using testing::Not;

std::string Loads() {
  return "/usr/lib/libHD.so.3.5";
}
std::string LoadsNot() {
  throw Error("openhaptics: no libHD.so here");
}

class Device : public testing::Test {
 protected:
  Device() {
    host.files.may_open = [this](const std::string& path) { return path != closed; };
  }
  MadeUpHost host;
  std::string closed;
};

TEST_F(Device, OfTheVendorNeedsItsLibraryAndANodeThatMayBeOpened) {
  host.Write("/dev/ttyACM0", "");
  const Finding fine = CheckDevice(host.files, "openhaptics", Loads);
  EXPECT_EQ(fine.status, Status::kOk);
  EXPECT_EQ(fine.found,
            "openhaptics: /usr/lib/libHD.so.3.5 is loaded; may be opened: /dev/ttyACM0");
  closed = "/dev/ttyACM0";
  const Finding refused = CheckDevice(host.files, "openhaptics", Loads);
  EXPECT_EQ(refused.status, Status::kFault);
  EXPECT_THAT(refused.remedy, HasSubstr("usermod -aG dialout"));
}

TEST_F(Device, OfTheVendorWithoutItsLibraryIsAFaultAndWithoutANodeAWarning) {
  const Finding library = CheckDevice(host.files, "openhaptics", LoadsNot);
  EXPECT_EQ(library.status, Status::kFault);
  EXPECT_THAT(library.found, HasSubstr("no libHD.so here"));
  EXPECT_THAT(library.remedy, HasSubstr("PALPATE_OPENHAPTICS_LIBRARY"));
  EXPECT_EQ(CheckDevice(host.files, "openhaptics", Loads).status, Status::kWarning);
}

TEST_F(Device, OfSpacenavdNeedsItToRun) {
  const Finding finding = CheckDevice(host.files, "spacemouse", LoadsNot);
  EXPECT_EQ(finding.status, Status::kFault);
  EXPECT_THAT(finding.remedy, HasSubstr("apt-get install spacenavd"));
  host.Write("/var/run/spnav.sock", "");
  EXPECT_EQ(CheckDevice(host.files, "spacemouse", LoadsNot).status, Status::kWarning);
  host.Write("/sys/class/hidraw/hidraw3/device/uevent",
             "DRIVER=hid-generic\nHID_ID=0003:0000256F:0000C635\n");
  const Finding fine = CheckDevice(host.files, "spacemouse", LoadsNot);
  EXPECT_EQ(fine.status, Status::kOk) << fine.found;
  closed = "/var/run/spnav.sock";
  EXPECT_EQ(CheckDevice(host.files, "spacemouse", LoadsNot).status, Status::kFault);
}

TEST_F(Device, ThatIsNotNamedIsNoFault) {
  const Finding finding = CheckDevice(host.files, "", LoadsNot);
  EXPECT_EQ(finding.status, Status::kOk);
  EXPECT_THAT(finding.found, Not(HasSubstr("openhaptics")));
  EXPECT_THAT(CheckDevice(host.files, "", Loads).found, HasSubstr("openhaptics"));
  EXPECT_EQ(CheckDevice(host.files, "simulated", LoadsNot).status, Status::kOk);
}

}  // namespace
}  // namespace palpate::doctor
