#include "devices/device_factory.h"
#include "devices/device_kind.h"
#include "devices/openhaptics/hd_library.h"
#include "devices/openhaptics/openhaptics_device.h"

namespace palpate {

DeviceKind OpenHapticsKind() {
  return {.name = "openhaptics",
          .what = "a PHANTOM or Touch arm, through the OpenHaptics library that is installed",
          .max_rate_Hz = 4000.0,
          .check_host = [] { hd::LoadLibrary(hd::LibraryCandidates()); },
          .make = [](const DeviceOptions& options) -> std::unique_ptr<Device> {
            OpenHapticsOptions arm;
            arm.name = options.arm;
            arm.calibrate = options.calibrate;
            arm.rate_Hz = options.rate_Hz;
            arm.realtime = options.realtime;
            return std::make_unique<OpenHapticsDevice>(std::move(arm));
          }};
}

}  // namespace palpate
