#pragma once

#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "devices/plugin/plugin_arm.h"

namespace palpate {

/// An arm of one's own: a driver in a shared object, by the functions of palpate_device.h, which is
/// on every kind of leash (plugin::PluginArm).  It has a loop of its own, so that a call which does
/// not return holds up no tick: each turn reads, has the station tick, and writes.
/// Thread contract: as Device.
class PluginDevice final : public Device {
 public:
  /// Throws Error: names file, symbol and remedy.
  explicit PluginDevice(const DeviceOptions& options);
  ~PluginDevice() override { StopTicks(); }

  const DeviceInfo& info() const override { return arm_->info; }
  DeviceSample Read() noexcept override { return arm_->sample; }
  void Apply(const LimitedWrench& wrench) noexcept override;
  bool StartTicks(std::function<void()> tick) override;
  /// A driver that hangs even now is left behind, with its thread.
  void StopTicks() override;
  std::string Attend() override { return arm_->Attend(); }
  const char* activity() const noexcept override { return arm_->ready() ? "" : "arm at fault"; }

  /// A single turn of the loop, while it does not run.
  void Turn(const std::function<void()>& tick) noexcept { arm_->Turn(tick); }

 private:
  struct Loop {
    std::shared_ptr<plugin::PluginArm> arm;
    std::function<void()> tick;
    std::atomic<bool> ended{false};
    std::atomic<bool> watched{true};

    void Run() noexcept;
    void Watch() noexcept;
  };

  // Shared with a thread that may be left behind.
  std::shared_ptr<plugin::PluginArm> arm_;
  std::shared_ptr<Loop> loop_;
  std::thread turns_, watch_;
};

}  // namespace palpate
