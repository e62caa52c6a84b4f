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
  Vec3 workspace_m = Vec3::Zero();         ///< size of the box that it reaches ...
  Vec3 workspace_centre_m = Vec3::Zero();  ///< ... about this point of its own frame
  double position_resolution_m = 0.0;
  double rotation_resolution_rad = 0.0;
  /// Way of the tool over way of the hand, and torque asked for over torque felt: a workspace's.
  /// All figures above are the tool's.
  double motion_scale = 1.0;
  bool simulated = false;  ///< its forces move no real hand
  /// Time constant of the motors' warmth [s].  [estimate] Few sheets give one.  A brushed motor of
  /// some 20 W has a winding that warms within about 12 s, over a fifth of the way to the air; one
  /// body of 60 s warms as fast as that at first, and is ahead of the real one from there on.
  double thermal_time_s = 60.0;

  double rate_Hz = 1000.0;  ///< ticks a second: how often it is to be read and driven

  int torque_axes = 3;  ///< that the motors drive: what is asked for about another is lost
  double max_stiffness_N_m = 0.0;  ///< of the mechanism, where it is weakest; 0: not known
};

/// Of a device that renders no force: generous bounds let the limiter show the server's wrench
/// nearly as it is.
inline DeviceInfo SheetWithoutForce(std::string model, double workspace_m) {
  DeviceInfo info;
  info.model = std::move(model);
  info.max_force_N = info.continuous_force_N = 100.0;
  info.max_torque_Nm = info.continuous_torque_Nm = 10.0;
  info.workspace_m = Vec3::Constant(workspace_m);
  info.simulated = true;
  return info;
}

/// One reading of the device.
struct DeviceSample {
  Pose X_WH;   ///< pose of the haptic tool (the handle) in the scene
  Twist V_WH;  ///< its velocity
  std::uint32_t buttons = 0;
  std::uint32_t status = kDeviceOk;
  /// Of the hottest motor as the device reports it, 0 cool to 1 its limit; NaN where it does not.
  double motor_temperature = std::numeric_limits<double>::quiet_NaN();
};

/// For Device::Attend: one more line, if it says anything.
inline void AddLine(std::string& lines, std::string_view line) {
  if (!lines.empty() && !line.empty()) lines += '\n';
  lines += line;
}

/// A haptic device, driven by the station's loop `info().rate_Hz` times a second: a tick is Read,
/// Shape, Apply.  How to add one: README.md.
class Device {
 public:
  virtual ~Device() = default;
  virtual const DeviceInfo& info() const = 0;
  /// Real-time: no allocation, lock or log.
  virtual DeviceSample Read() noexcept = 0;
  /// Commands the handle until the next tick: force at the handle's origin and torque about
  /// it, both in W.  Only a WrenchLimiter's output may come here; the type says so.  Real-time.
  virtual void Apply(const LimitedWrench& wrench) noexcept = 0;
  /// Where the scene's graphic tool was at the newest reply, before each Apply once there is one;
  /// for hands that see and do not feel.  Real-time.
  /// @param p_HT  point that the server's wrench acts at, in the tool's frame [m].
  virtual void SeeGraphicTool(const Pose& /*X_WG*/, const Vec3& /*p_HT*/) noexcept {}
  /// What the device makes of the wrench that the hand is to feel, before the limiter, once between
  /// Read and Apply.  As it stands, torque is lost where no motor turns the handle.  Real-time.
  /// @param contact  of the scene, at the handle's origin, in W.   @param led  what a guide adds.
  virtual void Shape(Wrench& contact, Wrench& led) noexcept {
    if (info().torque_axes == 0) contact.torque = led.torque = Vec3::Zero();
  }
  /// The session has ended: nothing is known of the graphic tool until it is seen again, in the
  /// next one.  Real-time.
  virtual void LoseGraphicTool() noexcept {}
  /// True once the hand will do nothing more: the station ends its session.
  virtual bool ended() const noexcept { return false; }
  /// What the hand does just now ("slide"), for people; empty where nobody knows.  Lives as long as
  /// the device.  Real-time.
  virtual const char* activity() const noexcept { return ""; }

  /// A device with a clock of its own calls `tick` from now on, from its own thread, once for each
  /// of its ticks: the wrench is then computed within the tick that applies it.  False: it has no
  /// clock, and who drives it keeps the time.
  /// @param tick  real-time, does not throw; calls Read and Apply.
  virtual bool StartTicks(std::function<void()> /*tick*/) { return false; }
  /// No tick runs when it has returned, and the device renders nothing.
  virtual void StopTicks() {}
  /// To be called some ten times a second or more, by the thread that made it, for what is not
  /// real-time: calibration, say.  What happened since, for people, a line each; mostly nothing.
  virtual std::string Attend() { return {}; }
};

}  // namespace palpate
