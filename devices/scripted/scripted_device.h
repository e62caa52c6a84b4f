#pragma once

#include "devices/device.h"
#include "devices/script_player.h"

namespace palpate {

/// Plays a script exactly, one millisecond per Apply: no mass, no hand, no noise.  Forces have no
/// effect (its status says so), so every run sends the same poses, bit for bit.
class ScriptedDevice final : public Device {
 public:
  static constexpr double kTick_s = 1e-3;

  explicit ScriptedDevice(ScriptPlayer script) : script_(std::move(script)) {}
  const DeviceInfo& info() const override { return info_; }
  DeviceSample Read() noexcept override;
  void Apply(const LimitedWrench& wrench) noexcept override;
  const char* activity() const noexcept override { return script_.LabelAt(time()); }

 private:
  double time() const noexcept { return kTick_s * static_cast<double>(ticks_); }

  const DeviceInfo info_ = SheetWithoutForce("scripted", 10.0);
  ScriptPlayer script_;
  long long ticks_ = 0;
};

}  // namespace palpate
