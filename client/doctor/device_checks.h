#pragma once

#include <functional>
#include <string>

#include "client/doctor/finding.h"
#include "client/doctor/host_files.h"

namespace palpate::doctor {

/// Loads the arm's library; returns the file that it was found in, or throws Error.
using LoadArmLibrary = std::function<std::string()>;
/// The real one: OpenHaptics'.
std::string LoadOpenHaptics();

/// Whether palpate-station --device could open the device.
/// @param device  as after --device, known; empty: none is named, and what is missing is no fault.
Finding CheckDevice(const HostFiles& host, const std::string& device, const LoadArmLibrary& load);

}  // namespace palpate::doctor
