#pragma once

#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "devices/device_factory.h"

namespace palpate {

/// An arm of one's own, by a driver in a shared object (palpate_device.h) that may do anything but
/// crash.  Each call is guarded, each reading checked, and each failure shuts a gate, from which
/// force returns by a ramp (ReturnGate).  A loop of its own reads, has the station tick, and
/// writes; where a call does not return within kHang_s, a second thread takes the force off.
/// Thread contract: as Device.
class PluginDevice final : public Device {
 public:
  static constexpr double kHang_s = 0.020;   ///< no turn takes longer
  static constexpr double kStuck_s = 0.010;  ///< without a new reading
  // No hand moves so far in a tick; an arm that is calibrated does.
  static constexpr double kJump_m = 0.05;
  static constexpr double kJump_rad = 0.5;

  /// Throws Error, which names file, function and remedy: it is no driver, or one of a later
  /// version, or fails, or its data sheet is none.
  explicit PluginDevice(const DeviceOptions& options);
  ~PluginDevice() override { StopTicks(); }

  const DeviceInfo& info() const override;
  DeviceSample Read() noexcept override;
  void Apply(const LimitedWrench& wrench) noexcept override;
  bool StartTicks(std::function<void()> tick) override;
  /// A driver that hangs even now is left behind, with its thread.
  void StopTicks() override;
  std::string Attend() override;
  const char* activity() const noexcept override;

  /// A single turn of the loop, while that does not run.
  void Turn(const std::function<void()>& tick) noexcept;

 private:
  class Arm;
  std::shared_ptr<Arm> arm_;  // shared with a thread that may be left behind
  std::thread turns_, watch_;
};

}  // namespace palpate
