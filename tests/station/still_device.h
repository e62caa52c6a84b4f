#pragma once

#include "devices/device.h"
#include "devices/wrench_limiter.h"

namespace palpate::test {

/// A device held still, which keeps what it was told.
class StillDevice : public Device {
 public:
  explicit StillDevice(double rate_Hz = 1000.0) {
    info_.model = "still";
    info_.rate_Hz = rate_Hz;
    info_.max_force_N = 22.0;
    info_.continuous_force_N = 3.0;
    info_.max_torque_Nm = 0.515;
    info_.continuous_torque_Nm = 0.188;
    info_.workspace_m = Vec3::Constant(0.4);
  }
  const DeviceInfo& info() const override { return info_; }
  DeviceSample Read() noexcept override { return sample; }
  void Apply(const LimitedWrench& wrench) noexcept override {
    applied = wrench.wrench();
    ++applications;
  }
  void SeeGraphicTool(const Pose&, const Vec3&) noexcept override { sees_graphic_tool = true; }
  void LoseGraphicTool() noexcept override { sees_graphic_tool = false; }

  DeviceSample sample;
  Wrench applied;
  int applications = 0;
  bool sees_graphic_tool = false;

 private:
  DeviceInfo info_;
};

}  // namespace palpate::test
