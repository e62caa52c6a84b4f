#pragma once

#include "devices/device.h"
#include "devices/wrench_limiter.h"

namespace palpate::test {

/// A device that is held still, and remembers what it was told.
class StillDevice final : public Device {
 public:
  StillDevice() {
    info_.model = "still";
    info_.max_force_N = 22.0;
    info_.continuous_force_N = 3.0;
    info_.max_torque_Nm = 0.515;
    info_.continuous_torque_Nm = 0.188;
  }
  const DeviceInfo& info() const override { return info_; }
  DeviceSample Read() noexcept override { return sample; }
  void Apply(const LimitedWrench& wrench) noexcept override {
    applied = wrench.wrench();
    ++applications;
  }

  DeviceSample sample;
  Wrench applied;
  int applications = 0;

 private:
  DeviceInfo info_;
};

}  // namespace palpate::test
