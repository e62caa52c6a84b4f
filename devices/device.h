#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <utility>

#include "common/math/pose.h"

namespace palpate {

class LimitedWrench;  // wrench_limiter.h: only the limiter makes one

/// The bits of a device's state, which is sent with every pose.
enum DeviceStatus : std::uint32_t {
  kDeviceOk = 0,
  kDeviceForcesEnabled = 1u << 0,
  kDeviceCalibrating = 1u << 1,
  kDeviceFault = 1u << 2,          ///< the driver reports an error; forces are off
  kDeviceForcesIgnored = 1u << 3,  ///< the device cannot render forces: Apply has no effect
};

/// The data sheet of a device, read once.  The code that sets a figure cites its source.
struct DeviceInfo {
  std::string model;
  double max_force_N = 0.0;         ///< peak, at the handle
  double continuous_force_N = 0.0;  ///< what the motors can sustain for ever
  double max_torque_Nm = 0.0;       ///< peak, about the handle's strongest axis
  double continuous_torque_Nm = 0.0;
  Vec3 workspace_m = Vec3::Zero();         ///< size of the box that the handle can reach ... ...
  Vec3 workspace_centre_m = Vec3::Zero();  ///< ... ... around this point of the device's own frame
  double position_resolution_m = 0.0;
  double rotation_resolution_rad = 0.0;
  /// Motion of the tool over motion of the hand, and torque requested over torque felt; set by a
  /// workspace.  All figures above are those at the tool.
  double motion_scale = 1.0;
  bool simulated = false;  ///< its forces do not act on a real hand
  /// Thermal time constant of the motors [s].  [estimate] Few data sheets give one.  In a brushed
  /// motor of some 20 W the winding, which has a fifth of the thermal resistance to the air, warms
  /// within about 12 s.  A single body with 60 s warms as fast at first, and faster than the real
  /// motor later.
  double thermal_time_s = 60.0;

  double rate_Hz = 1000.0;  ///< ticks per second: how often to call Read and Apply

  int torque_axes = 3;  ///< number of axes whose torque the motors can drive; torque about others
                        ///< is lost
  double max_stiffness_N_m = 0.0;  ///< of the mechanism, in its weakest direction; 0: not known
};

/// Returns the data sheet of a device that renders no force.  Its bounds are generous, so that the
/// limiter passes the server's wrench nearly unchanged for display.
inline DeviceInfo SheetWithoutForce(std::string model, double workspace_m) {
  DeviceInfo info;
  info.model = std::move(model);
  info.max_force_N = info.continuous_force_N = 100.0;
  info.max_torque_Nm = info.continuous_torque_Nm = 10.0;
  info.workspace_m = Vec3::Constant(workspace_m);
  info.simulated = true;
  return info;
}

/// One reading of a device.
struct DeviceSample {
  Pose X_WH;   ///< pose of the haptic tool (the handle) in the scene
  Twist V_WH;  ///< its velocity
  std::uint32_t buttons = 0;
  std::uint32_t status = kDeviceOk;
  /// Temperature of the hottest motor as the device reports it, from 0 (cool) to 1 (its limit;
  /// above counts as 1); NaN if it reports none.
  double motor_temperature = std::numeric_limits<double>::quiet_NaN();
};

/// Appends a line for Device::Attend, unless it is empty.
inline void AddLine(std::string& lines, std::string_view line) {
  if (!lines.empty() && !line.empty()) lines += '\n';
  lines += line;
}

/// What a device tells people, one line each.
struct DeviceNews {
  std::string faults;  ///< why it gives no force, or less, and what to do
  std::string notes;   ///< for instance that forces are back
  bool empty() const { return faults.empty() && notes.empty(); }
  std::string Lines() const {
    std::string lines = faults;
    AddLine(lines, notes);
    return lines;
  }
};

/// A loop that runs at less than this share of its device's rate is too slow for haptics.
inline constexpr double kLeastRate = 0.9;

/// A haptic device.  The station's loop drives it `info().rate_Hz` times a second; a tick is Read,
/// Shape, Apply.  README.md says how to add one.
class Device {
 public:
  virtual ~Device() = default;
  virtual const DeviceInfo& info() const = 0;
  /// Reads the device.  Real-time: no allocation, lock or log.
  virtual DeviceSample Read() noexcept = 0;
  /// Commands the handle until the next tick: force at the handle's origin and torque about it,
  /// both in W.  The type ensures that only a WrenchLimiter's output can be passed.  Real-time.
  virtual void Apply(const LimitedWrench& wrench) noexcept = 0;
  /// Tells the device the pose of the graphic tool in the newest reply, before each Apply once
  /// there is a reply; for hands that see but do not feel.  Real-time.
  /// p_HT: point at which the server's wrench acts, in the tool's frame [m].
  virtual void SeeGraphicTool(const Pose& /*X_WG*/, const Vec3& /*p_HT*/) noexcept {}
  /// Lets the device change the wrench that the hand is to feel, before the limiter, once between
  /// Read and Apply.  By default it removes the torque if no motor turns the handle.  Real-time.
  /// @param contact  the scene's wrench at the handle's origin, in W.
  /// @param led  what a guide adds.
  virtual void Shape(Wrench& contact, Wrench& led) noexcept {
    if (info().torque_axes == 0) contact.torque = led.torque = Vec3::Zero();
  }
  /// Tells the device that the session has ended: the graphic tool is unknown until the next
  /// session shows it.  Real-time.
  virtual void LoseGraphicTool() noexcept {}
  /// Returns true once the hand will do nothing more; the station then ends its session.
  virtual bool ended() const noexcept { return false; }
  /// Returns what the hand is doing ("slide"), for people; empty if unknown.  The text lives as
  /// long as the device.  Real-time.
  virtual const char* activity() const noexcept { return ""; }

  /// Makes a device with a clock of its own call `tick` from its own thread, once per device tick,
  /// so that the wrench is computed within the tick that applies it.  Returns false if the device
  /// has no clock; the caller must then keep time.
  /// `tick` is real-time and does not throw; it calls Read and Apply.
  virtual bool StartTicks(std::function<void()> /*tick*/) { return false; }
  /// Stops the ticks: once it has returned, no tick runs, and the device renders nothing.
  virtual void StopTicks() {}
  /// Does what is not real-time, such as calibration.  The thread that made the device calls it at
  /// least some ten times a second.  Returns the news since the last call; mostly empty.
  virtual DeviceNews Attend() { return {}; }
};

}  // namespace palpate
