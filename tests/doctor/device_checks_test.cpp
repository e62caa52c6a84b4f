#include "client/doctor/device_checks.h"

#include "common/error.h"
#include "tests/doctor/made_up_host.h"

namespace palpate::doctor {
namespace {

using testing::HasSubstr;
using testing::Not;

const ArmProbes kLoads{.openhaptics = [] { return "/usr/lib/libHD.so.3.5 is loaded"; },
                       .forcedimension = [] { return "libdhd.so.3 is loaded"; },
                       .haply = [] { return "somebody listens at ws://localhost:10001"; }};
const ArmProbes kLoadsNot{
    .openhaptics = []() -> std::string { throw Error("openhaptics: no libHD.so here"); },
    .forcedimension = []() -> std::string { throw Error("forcedimension: no libdhd here"); },
    .haply = []() -> std::string { throw Error("haply: no Inverse Service"); }};

class Device : public testing::Test {
 protected:
  Device() {
    host.files.may_open = [this](const std::string& path) { return path != closed; };
  }
  Finding Check(const char* device, const ArmProbes& probes = kLoads) const {
    return CheckDevice(host.files, device, probes);
  }
  MadeUpHost host;
  std::string closed;
};

TEST_F(Device, OfTheVendorNeedsItsLibraryAndANodeThatMayBeOpened) {
  EXPECT_THAT(Check("openhaptics", kLoadsNot),
              IsFault("no libHD.so here", "PALPATE_OPENHAPTICS_LIBRARY"));
  EXPECT_THAT(Check("openhaptics"), IsWarning("no arm is plugged in"));
  host.Write("/dev/ttyACM0", "");
  EXPECT_THAT(Check("openhaptics"),
              IsOk("openhaptics: /usr/lib/libHD.so.3.5 is loaded; may be opened: /dev/ttyACM0"));
  closed = "/dev/ttyACM0";
  EXPECT_THAT(Check("openhaptics"), IsFault(closed, "usermod -aG dialout"));
}

TEST_F(Device, OfForceDimensionNeedsItsLibraryAndAnArmThatMayBeOpened) {
  EXPECT_THAT(Check("forcedimension", kLoadsNot), IsFault("", "PALPATE_FORCEDIMENSION_LIBRARY"));
  EXPECT_THAT(Check("forcedimension"), IsWarning());
  host.Write("/sys/bus/usb/devices/1-2/idVendor", "1451\n");
  host.Write("/sys/bus/usb/devices/1-2/busnum", "1\n");
  host.Write("/sys/bus/usb/devices/1-2/devnum", "12\n");
  EXPECT_THAT(Check("forcedimension"),
              IsOk("libdhd.so.3 is loaded; may be opened: /dev/bus/usb/001/012"));
  closed = "/dev/bus/usb/001/012";
  EXPECT_THAT(Check("forcedimension"), IsFault(closed, "udev rule"));
}

TEST_F(Device, OfHaplyNeedsItsService) {
  EXPECT_THAT(Check("haply"), IsOk());
  EXPECT_THAT(Check("haply", kLoadsNot), IsFault("", "systemctl start haply-inverse-service"));
  EXPECT_THAT(Check("haply", kLoadsNot), IsFault("", "PALPATE_HAPLY_SERVICE"));
}

TEST_F(Device, OfSpacenavdNeedsItToRun) {
  EXPECT_THAT(Check("spacemouse"), IsFault("", "apt-get install spacenavd"));
  host.Write("/var/run/spnav.sock", "");
  EXPECT_THAT(Check("spacemouse"), IsWarning("no puck"));
  host.Write("/sys/class/hidraw/hidraw3/device/uevent",
             "DRIVER=hid-generic\nHID_ID=0003:0000256F:0000C635\n");
  EXPECT_THAT(Check("spacemouse"), IsOk("a puck is plugged in"));
  closed = "/var/run/spnav.sock";
  EXPECT_THAT(Check("spacemouse"), IsFault());
}

TEST_F(Device, ThatIsNotNamedIsNoFault) {
  EXPECT_THAT(Check("", kLoadsNot), IsOk());
  EXPECT_THAT(Check("", kLoadsNot).found, Not(HasSubstr("openhaptics")));
  EXPECT_THAT(Check(""), IsOk("openhaptics"));
  EXPECT_THAT(Check("simulated", kLoadsNot), IsOk());
}

}  // namespace
}  // namespace palpate::doctor
