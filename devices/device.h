#pragma once

#include <cstdint>
#include <string>

#include "common/math/pose.h"

namespace palpate {

class LimitedWrench;  // wrench_limiter.h: only the limiter makes one

/// Bits of a device's state, sent with every pose.
enum DeviceStatus : std::uint32_t {
  kDeviceOk = 0,
  kDeviceForcesEnabled = 1u << 0,
  kDeviceCalibrating = 1u << 1,
  kDeviceFault = 1u << 2,          ///< the driver reports an error; forces are off
  kDeviceForcesIgnored = 1u << 3,  ///< it cannot render forces: what Apply is given has no effect
};

/// What a device is, read once: a data sheet.  Figures carry their source where they are set.
struct DeviceInfo {
  std::string model;
  double max_force_N = 0.0;         ///< peak, at the handle
  double continuous_force_N = 0.0;  ///< what the motors stand for ever
  double max_torque_Nm = 0.0;       ///< peak, about the handle's strongest axis
  double continuous_torque_Nm = 0.0;
  Vec3 workspace_m = Vec3::Zero();  ///< size of the box it reaches, centred on W's origin
  double position_resolution_m = 0.0;
  double rotation_resolution_rad = 0.0;
  bool simulated = false;  ///< its forces move no real hand
};

/// One reading of the device.
struct DeviceSample {
  Pose X_WH;   ///< pose of the haptic tool (the handle) in the scene
  Twist V_WH;  ///< its velocity
  std::uint32_t buttons = 0;
  std::uint32_t status = kDeviceOk;
};

/// A haptic device, driven once a millisecond by the station's loop: Read, then Apply.  How to add
/// one: README.md.
class Device {
 public:
  virtual ~Device() = default;
  virtual const DeviceInfo& info() const = 0;
  /// Real-time: no allocation, lock or log.
  virtual DeviceSample Read() noexcept = 0;
  /// Commands the handle for the millisecond to come: force at the handle's origin and torque about
  /// it, both in W.  Only a WrenchLimiter's output may come here; the type says so.  Real-time.
  virtual void Apply(const LimitedWrench& wrench) noexcept = 0;
  /// Where the scene's graphic tool was at the newest reply, before each Apply once there is one;
  /// for hands that see and do not feel.  Real-time.
  /// @param p_HT  point that the server's wrench acts at, in the tool's frame [m].
  virtual void SeeGraphicTool(const Pose& /*X_WG*/, const Vec3& /*p_HT*/) noexcept {}
  /// The session has ended: nothing is known of the graphic tool until it is seen again, in the
  /// next one.  Real-time.
  virtual void LoseGraphicTool() noexcept {}
  /// True once the hand will do nothing more: the station ends its session.
  virtual bool ended() const noexcept { return false; }
  /// What the hand does just now ("slide"), for people; empty where nobody knows.  Lives as long as
  /// the device.  Real-time.
  virtual const char* activity() const noexcept { return ""; }
};

}  // namespace palpate
