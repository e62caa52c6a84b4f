#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "devices/device.h"

namespace palpate {

struct DeviceOptions;  // device_factory.h

/// What a folder below devices/ gives to the station: a kind of device, and how one is opened.
struct DeviceKind {
  std::string_view name;  ///< as after --device
  std::string_view what;  ///< a line for the help
  bool needs_script = false;
  std::vector<std::string_view> models{};  ///< as after --model, the default first; empty: but one
  double max_rate_Hz = 1000.0;             ///< as after --rate
  /// Throws Error as `make` does where the host has not what the driver needs, and opens no device;
  /// null: it needs nothing.
  void (*check_host)() = nullptr;
  /// Throws Error, which says what was looked for and what to do.
  std::unique_ptr<Device> (*make)(const DeviceOptions&) = nullptr;
};

/// Every kind that this version has, by name; written by CMake from the folders.
std::vector<DeviceKind> AllDeviceKinds();

}  // namespace palpate
