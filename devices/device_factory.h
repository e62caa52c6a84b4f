#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/json/pose_script.h"
#include "common/program/realtime.h"
#include "devices/device.h"
#include "devices/workspace.h"

namespace palpate {

struct DeviceOptions {
  std::string name;                      ///< as after --device
  std::optional<PoseScript> script;      ///< what the hand of a simulated or scripted device does
  bool loop = false;                     ///< again and again
  Pose start{};                          ///< of a device that has no script: where its tool begins
  std::string model{};                   ///< as after --model; empty: the kind's first
  double rate_Hz = 1000.0;               ///< Read and Apply, a second
  std::optional<Workspace> workspace{};  ///< how the device lies in the scene; none: as it is
  // Of a real arm.
  std::string arm{};           ///< as its vendor's set-up program names it; empty: the default one
  bool calibrate = false;      ///< even where it says that it need not be
  RealtimeOptions realtime{};  ///< of its own thread
};

/// Names that MakeDevice takes, separated by ", ": for help and messages.
std::string DeviceNames();

/// A line for each device, with its models: for help.
std::string DeviceHelp();

/// True where --device names the file of a driver: it has a slash in it, or ends in .so.
bool IsDriverFile(const std::string& name);

/// True where the device needs a script.  Throws UsageError for a name that there is not.
bool DeviceNeedsScript(const std::string& name);

/// Throws UsageError, which names what there is, for a device, a model or a rate that there is not.
void CheckDevice(const std::string& name, const std::string& model, double rate_Hz);

/// Throws Error where the host has not what the device's driver needs: a vendor's library, or a
/// service that listens.  Opens no device.  Throws UsageError for a name that there is not.
void CheckDriver(const std::string& name);

/// Opens a device.  Script and start are poses of the tool in the scene, whatever the workspace.
/// Throws UsageError as CheckDevice does, and Error where the script is missing or the device
/// cannot be opened.
std::unique_ptr<Device> MakeDevice(const DeviceOptions& options);

struct DeviceOptions;  // device_factory.h

/// What a folder below devices/ gives to the station: a kind of device, and how one is opened.
struct DeviceKind {
  std::string_view name;  ///< as after --device
  std::string_view what;  ///< a line for the help
  bool needs_script = false;
  std::vector<std::string_view> models{};  ///< as after --model, the default first; empty: but one
  double max_rate_Hz = 1000.0;             ///< as after --rate
  bool is_file = false;                    ///< --device names a driver's file in its place
  /// Throws Error as `make` does where the host has not what the driver needs, and opens no device;
  /// null: it needs nothing.
  /// @param name  as after --device.
  void (*check_host)(const std::string& name) = nullptr;
  /// Throws Error, which says what was looked for and what to do.
  std::unique_ptr<Device> (*make)(const DeviceOptions&) = nullptr;
};

/// Every kind that this version has, by name; written by CMake from the folders.
std::vector<DeviceKind> AllDeviceKinds();

}  // namespace palpate
