#pragma once

#include <cstdint>
#include <string>

#include "common/math/pose.h"

namespace palpate {

/// Bits of a device's state, sent with every pose.
enum DeviceStatus : std::uint32_t {
  kDeviceOk = 0,
  kDeviceForcesEnabled = 1u << 0,
  kDeviceCalibrating = 1u << 1,
  kDeviceFault = 1u << 2,  ///< the driver reports an error; forces are off
};

/// What a device is, read once: a data sheet.  Figures carry their source where they are set.
struct DeviceInfo {
  std::string model;
  double max_force_N = 0.0;               ///< peak, at the handle
  double continuous_force_N = 0.0;
  double max_torque_Nm = 0.0;
  double continuous_torque_Nm = 0.0;
  Vec3 workspace_m = Vec3::Zero();        ///< size of the box it reaches
  double position_resolution_m = 0.0;
  double rotation_resolution_rad = 0.0;
  bool simulated = false;                 ///< its forces move no real hand
};

/// One reading of the device.
struct DeviceSample {
  Pose X_WH;        ///< pose of the haptic tool in the scene
  Twist V_WH;       ///< its velocity
  std::uint32_t buttons = 0;
  std::uint32_t status = kDeviceOk;
};

/// A haptic device, driven once a millisecond by the station's loop: Read, then Apply.
class Device {
 public:
  virtual ~Device() = default;
  virtual const DeviceInfo& info() const = 0;
  /// Real-time: no allocation, lock or log.
  virtual DeviceSample Read() noexcept = 0;
  /// Commands the handle.  Only a WrenchLimiter's output may come here; the type says so.
  virtual void Apply(const class LimitedWrench& wrench) noexcept = 0;
};

}  // namespace palpate
