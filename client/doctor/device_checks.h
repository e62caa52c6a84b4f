#pragma once

#include <functional>
#include <string>

#include "client/doctor/finding.h"
#include "client/doctor/host_files.h"

namespace palpate::doctor {

/// Whether what an arm needs beside the kernel answers: what was found, in a few words; throws
/// Error.
using Probe = std::function<std::string()>;

/// Of the vendors' libraries and services, so that a test needs none of them.
struct ArmProbes {
  Probe openhaptics;     ///< loads the library
  Probe forcedimension;  ///< loads the library
  Probe haply;           ///< connects to the service
};
ArmProbes RealArmProbes();

/// Whether palpate-station --device could open the device.
/// @param device  as after --device, known; empty: none is named, and what is missing is no fault.
Finding CheckDevice(const HostFiles& host, const std::string& device, const ArmProbes& probes);

}  // namespace palpate::doctor
