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
  std::string name;                      ///< the argument of --device
  std::optional<PoseScript> script;      ///< motion of the hand of a simulated or scripted device
  bool loop = false;                     ///< repeats the script
  Pose start{};                          ///< start pose of the tool, for a device without a script
  std::string model{};                   ///< the argument of --model; empty: the kind's first
  double rate_Hz = 1000.0;               ///< calls of Read and Apply per second
  std::optional<Workspace> workspace{};  ///< how the device is placed in the scene; none: as it is
  // For a real arm:
  std::string arm{};           ///< its name in the vendor's set-up program; empty: the default arm
  bool calibrate = false;      ///< calibrates even if the arm says that it need not
  RealtimeOptions realtime{};  ///< for its own thread
};

/// Returns the names that MakeDevice accepts, separated by ", ", for help and messages.
std::string DeviceNames();

/// Returns a line for each device with its models, for help.
std::string DeviceHelp();

/// Returns true if --device names a driver's file: the name contains a slash, or ends in .so.
bool IsDriverFile(const std::string& name);

/// Returns true if the device needs a script.  Throws UsageError for an unknown name.
bool DeviceNeedsScript(const std::string& name);

/// Throws UsageError, which lists the valid ones, for an unknown device or model, or for an
/// invalid rate.
void CheckDevice(const std::string& name, const std::string& model, double rate_Hz);

/// Throws Error if the host lacks what the device's driver needs: a vendor's library, or a running
/// service.  Opens no device.  Throws UsageError for an unknown name.
void CheckDriver(const std::string& name);

/// Opens a device.  Script and start are poses of the tool in the scene, even with a workspace.
/// Throws UsageError as CheckDevice does, and Error if the script is missing or the device cannot
/// be opened.
std::unique_ptr<Device> MakeDevice(const DeviceOptions& options);

struct DeviceOptions;  // device_factory.h

/// A kind of device and how to open one, as a folder below devices/ declares it to the station.
struct DeviceKind {
  std::string_view name;  ///< the argument of --device
  std::string_view what;  ///< one line of help
  bool needs_script = false;
  std::vector<std::string_view> models{};  ///< arguments of --model, the default first; empty: only
                                           ///< one model
  double max_rate_Hz = 1000.0;             ///< greatest argument of --rate
  bool is_file = false;                    ///< --device names a driver's file instead of the kind
  /// Throws Error as `make` does if the host lacks what the driver needs, but opens no device;
  /// null: the driver needs nothing.
  /// @param name  the argument of --device.
  void (*check_host)(const std::string& name) = nullptr;
  /// Opens the device.  Throws Error, which says what was looked for and what to do.
  std::unique_ptr<Device> (*make)(const DeviceOptions&) = nullptr;
};

/// Returns all kinds of this version, ordered by name; CMake generates it from the folders.
std::vector<DeviceKind> AllDeviceKinds();

}  // namespace palpate
