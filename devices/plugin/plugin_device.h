#pragma once

#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "devices/device_factory.h"

namespace palpate {

/// A user's own arm, with a driver in a shared object (palpate_device.h) that may misbehave in any
/// way except crash.  Each call is guarded and each reading checked; each failure closes a gate,
/// after which force returns by a ramp (ReturnGate).  A loop of its own reads, runs the station's
/// tick, and writes; if a call does not return within kHang_s, a second thread removes the force.
/// Thread contract: as Device.
class PluginDevice final : public Device {
 public:
  static constexpr double kHang_s = 0.020;   ///< the longest turn of the loop
  static constexpr double kStuck_s = 0.010;  ///< the longest time without a new reading
  // A change of the pose in a tick that no hand makes, but an arm that is being calibrated may.
  static constexpr double kJump_m = 0.05;
  static constexpr double kJump_rad = 0.5;

  /// Throws Error, which names file, function and remedy, if the file is no driver or one for a
  /// later version, if the driver fails, or if its data sheet is invalid.
  explicit PluginDevice(const DeviceOptions& options);
  ~PluginDevice() override { StopTicks(); }

  const DeviceInfo& info() const override;
  DeviceSample Read() noexcept override;
  void Apply(const LimitedWrench& wrench) noexcept override;
  bool StartTicks(std::function<void()> tick) override;
  /// Stops the loop.  A driver that hangs even now is abandoned, with its thread.
  void StopTicks() override;
  DeviceNews Attend() override;
  const char* activity() const noexcept override;

  /// Runs a single turn of the loop; only while the loop does not run.
  void Turn(const std::function<void()>& tick) noexcept;

 private:
  class Arm;
  std::shared_ptr<Arm> arm_;  // shared with a thread that may be abandoned
  std::thread turns_, watch_;
};

}  // namespace palpate
