#include "client/doctor/device_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/error.h"
#include "tests/doctor/made_up_host.h"

namespace palpate::doctor {
namespace {

using testing::HasSubstr;
using testing::Not;

const ArmProbes Loads{.openhaptics = [] { return "/usr/lib/libHD.so.3.5 is loaded"; },
                      .forcedimension = [] { return "libdhd.so.3 is loaded"; },
                      .haply = [] { return "somebody listens at ws://localhost:10001"; }};
const ArmProbes LoadsNot{
    .openhaptics = []() -> std::string { throw Error("openhaptics: no libHD.so here"); },
    .forcedimension = []() -> std::string { throw Error("forcedimension: no libdhd here"); },
    .haply = []() -> std::string { throw Error("haply: no Inverse Service"); }};

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

TEST_F(Device, OfForceDimensionNeedsItsLibraryAndAnArmThatMayBeOpened) {
  const Finding library = CheckDevice(host.files, "forcedimension", LoadsNot);
  EXPECT_EQ(library.status, Status::kFault);
  EXPECT_THAT(library.remedy, HasSubstr("PALPATE_FORCEDIMENSION_LIBRARY"));
  EXPECT_EQ(CheckDevice(host.files, "forcedimension", Loads).status, Status::kWarning);
  host.Write("/sys/bus/usb/devices/1-2/idVendor", "1451\n");
  host.Write("/sys/bus/usb/devices/1-2/busnum", "1\n");
  host.Write("/sys/bus/usb/devices/1-2/devnum", "12\n");
  const Finding fine = CheckDevice(host.files, "forcedimension", Loads);
  EXPECT_EQ(fine.status, Status::kOk);
  EXPECT_THAT(fine.found, HasSubstr("libdhd.so.3 is loaded; may be opened: /dev/bus/usb/001/012"));
  closed = "/dev/bus/usb/001/012";
  const Finding refused = CheckDevice(host.files, "forcedimension", Loads);
  EXPECT_EQ(refused.status, Status::kFault);
  EXPECT_THAT(refused.remedy, HasSubstr("udev rule"));
}

TEST_F(Device, OfHaplyNeedsItsService) {
  EXPECT_EQ(CheckDevice(host.files, "haply", Loads).status, Status::kOk);
  const Finding silent = CheckDevice(host.files, "haply", LoadsNot);
  EXPECT_EQ(silent.status, Status::kFault);
  EXPECT_THAT(silent.remedy, HasSubstr("systemctl start haply-inverse-service"));
  EXPECT_THAT(silent.remedy, HasSubstr("PALPATE_HAPLY_SERVICE"));
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
