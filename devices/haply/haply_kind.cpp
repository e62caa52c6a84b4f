#include "devices/device_factory.h"
#include "devices/device_kind.h"
#include "devices/haply/haply_device.h"
#include "devices/haply/inverse_client.h"

namespace palpate {

DeviceKind HaplyKind() {
  return {.name = "haply",
          .what =
              "Haply Inverse3 with VerseGrip, through its Inverse Service at "
              "ws://localhost:10001; --device-name ID",
          .max_rate_Hz = 2000.0,
          .check_host = [] { haply::CheckService(haply::ServiceAddress()); },
          .make = [](const DeviceOptions& options) -> std::unique_ptr<Device> {
            HaplyOptions arm;
            arm.device_id = options.arm;
            arm.rate_Hz = options.rate_Hz;
            arm.realtime = options.realtime;
            return std::make_unique<HaplyDevice>(arm);
          }};
}

}  // namespace palpate
