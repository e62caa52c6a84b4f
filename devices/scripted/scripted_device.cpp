#include "devices/scripted/scripted_device.h"

#include "devices/device_factory.h"

namespace palpate {

DeviceSample ScriptedDevice::Read() noexcept {
  return {script_.At(time()), script_.VelocityAt(time()), 0, kDeviceForcesIgnored};
}

void ScriptedDevice::Apply(const LimitedWrench&) noexcept {
  ++ticks_;
}

DeviceKind ScriptedKind() {
  return {.name = "scripted",
          .what = "plays a script exactly; renders no force",
          .needs_script = true,
          .make = [](const DeviceOptions& options) -> std::unique_ptr<Device> {
            return std::make_unique<ScriptedDevice>(ScriptPlayer(*options.script, options.loop));
          }};
}

}  // namespace palpate
