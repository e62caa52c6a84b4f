#include "devices/device_factory.h"
#include "devices/device_kind.h"
#include "devices/scripted/scripted_device.h"

namespace palpate {

DeviceKind ScriptedKind() {
  return {.name = "scripted",
          .what = "a script played exactly; renders no force",
          .needs_script = true,
          .make = [](const DeviceOptions& options) -> std::unique_ptr<Device> {
            return std::make_unique<ScriptedDevice>(ScriptPlayer(*options.script, options.loop));
          }};
}

}  // namespace palpate
