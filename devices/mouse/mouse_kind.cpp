#include <unistd.h>

#include "devices/device_factory.h"
#include "devices/device_kind.h"
#include "devices/mouse/mouse_device.h"

namespace palpate {

DeviceKind MouseKind() {
  return {.name = "mouse",
          .what = "a hand that follows lines on standard input; sees, and feels nothing",
          .make = [](const DeviceOptions& options) -> std::unique_ptr<Device> {
            return std::make_unique<MouseDevice>(STDIN_FILENO, options.start);
          }};
}

}  // namespace palpate
