#include "devices/device_factory.h"

#include <array>
#include <string_view>
#include <utility>

#include <unistd.h>

#include "common/error.h"
#include "devices/mouse/mouse_device.h"
#include "devices/openhaptics/openhaptics_device.h"
#include "devices/scripted/scripted_device.h"
#include "devices/simulated/simulated_phantom.h"

namespace palpate {
namespace {

struct Entry {
  std::string_view name;
  bool needs_script;
  std::unique_ptr<Device> (*make)(const DeviceOptions&);  // null: known, but not in this version
};

std::unique_ptr<Device> MakeSimulated(const DeviceOptions& options) {
  const Pose start = options.script->At(0.0);
  SimulatedHand hand(ScriptPlayer(*options.script, options.loop), HandImpedance{});
  return std::make_unique<SimulatedPhantom>(PhantomPremium30Info(), PhantomPremium30Dynamics(),
                                            std::move(hand), start);
}

std::unique_ptr<Device> MakeScripted(const DeviceOptions& options) {
  return std::make_unique<ScriptedDevice>(ScriptPlayer(*options.script, options.loop));
}

std::unique_ptr<Device> MakeMouse(const DeviceOptions& options) {
  return std::make_unique<MouseDevice>(STDIN_FILENO, options.start);
}

std::unique_ptr<Device> MakeOpenHaptics(const DeviceOptions& options) {
  OpenHapticsOptions arm;
  arm.name = options.arm;
  arm.calibrate = options.calibrate;
  arm.rate_Hz = options.rate_Hz;
  arm.realtime = options.realtime;
  return std::make_unique<OpenHapticsDevice>(std::move(arm));
}

constexpr std::array<Entry, 5> kDevices{{{"simulated", true, MakeSimulated},
                                         {"scripted", true, MakeScripted},
                                         {"openhaptics", false, MakeOpenHaptics},
                                         {"spacemouse", false, nullptr},
                                         {"mouse", false, MakeMouse}}};

const Entry& Find(const std::string& name) {
  for (const Entry& entry : kDevices) {
    if (entry.name != name) continue;
    if (entry.make) return entry;
    throw UsageError("--device " + name + ": not built into this version; have: " + DeviceNames());
  }
  throw UsageError("--device " + name + ": no such device; have: " + DeviceNames());
}

}  // namespace

std::string DeviceNames() {
  std::string names;
  for (const Entry& entry : kDevices) {
    if (!entry.make) continue;
    if (!names.empty()) names += ", ";
    names += entry.name;
  }
  return names;
}

bool DeviceNeedsScript(const std::string& name) {
  return Find(name).needs_script;
}

std::unique_ptr<Device> MakeDevice(const DeviceOptions& options) {
  const Entry& entry = Find(options.name);
  if (entry.needs_script && !options.script) {
    throw Error("--device " + options.name + " needs a script of poses; give one with --script");
  }
  return entry.make(options);
}

}  // namespace palpate
