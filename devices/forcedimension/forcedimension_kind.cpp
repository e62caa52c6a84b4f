#include "devices/device_factory.h"
#include "devices/device_kind.h"
#include "devices/forcedimension/dhd_library.h"
#include "devices/forcedimension/forcedimension_device.h"

namespace palpate {

DeviceKind ForceDimensionKind() {
  return {.name = "forcedimension",
          .what =
              "omega, delta, sigma or lambda, through Force Dimension's library libdhd.so.3; "
              "--device-name SERIAL",
          .max_rate_Hz = 4000.0,
          .check_host = [] { dhd::LoadLibrary(dhd::LibraryCandidates()); },
          .make = [](const DeviceOptions& options) -> std::unique_ptr<Device> {
            ForceDimensionOptions arm;
            arm.serial = options.arm;
            arm.calibrate = options.calibrate;
            arm.rate_Hz = options.rate_Hz;
            return std::make_unique<ForceDimensionDevice>(std::move(arm));
          }};
}

}  // namespace palpate
