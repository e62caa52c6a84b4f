#include "devices/scripted/scripted_device.h"

#include <utility>

#include "devices/device_factory.h"

namespace palpate {

ScriptedDevice::ScriptedDevice(ScriptPlayer script) : script_(std::move(script)) {
  info_.model = "scripted";
  // It renders nothing; generous bounds let the limiter show the server's wrench nearly as it is.
  info_.max_force_N = info_.continuous_force_N = 100.0;
  info_.max_torque_Nm = info_.continuous_torque_Nm = 10.0;
  info_.workspace_m = Vec3::Constant(10.0);
  info_.simulated = true;
}

DeviceSample ScriptedDevice::Read() noexcept {
  return {script_.At(time()), script_.VelocityAt(time()), 0, kDeviceForcesIgnored};
}

void ScriptedDevice::Apply(const LimitedWrench&) noexcept {
  ++ticks_;
}

DeviceKind ScriptedKind() {
  return {.name = "scripted",
          .what = "a script played exactly; renders no force",
          .needs_script = true,
          .make = [](const DeviceOptions& options) -> std::unique_ptr<Device> {
            return std::make_unique<ScriptedDevice>(ScriptPlayer(*options.script, options.loop));
          }};
}

}  // namespace palpate
