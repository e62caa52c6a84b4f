#pragma once

#include <memory>
#include <optional>
#include <string>

#include "common/realtime/realtime.h"
#include "devices/device.h"
#include "scenes/pose_script.h"

namespace palpate {

struct DeviceOptions {
  std::string name;                  ///< as after --device
  std::optional<PoseScript> script;  ///< what the hand of a simulated or scripted device does
  bool loop = false;                 ///< again and again
  Pose start{};                      ///< of a device that has no script: where its tool begins
  // Of a real arm.
  std::string arm{};       ///< as its vendor's set-up program names it; empty: the default one
  bool calibrate = false;  ///< even where it says that it need not be
  double rate_Hz = 1000.0;
  RealtimeOptions realtime{};  ///< of its own thread
};

/// Names that MakeDevice takes, separated by ", ": for help and messages.
std::string DeviceNames();

/// True where the device needs a script.  Throws UsageError as MakeDevice does.
bool DeviceNeedsScript(const std::string& name);

/// Throws UsageError for a name that is unknown or not built into this version, and Error where
/// the script is missing.
std::unique_ptr<Device> MakeDevice(const DeviceOptions& options);

}  // namespace palpate
