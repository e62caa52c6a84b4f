#include "devices/device_factory.h"
#include "devices/device_kind.h"
#include "devices/spacemouse/space_mouse_device.h"
#include "devices/spacemouse/spacenav_reader.h"

namespace palpate {

DeviceKind SpaceMouseKind() {
  return {.name = "spacemouse",
          .what =
              "a SpaceMouse through spacenavd: as far as it is pushed, so fast the tool moves; "
              "no force",
          .check_host = FindSpacenavd,
          .make = [](const DeviceOptions& options) -> std::unique_ptr<Device> {
            return std::make_unique<SpaceMouseDevice>(options.start);
          }};
}

}  // namespace palpate
