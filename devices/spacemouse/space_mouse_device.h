#pragma once

#include "devices/blind_hand.h"
#include "devices/device.h"
#include "devices/spacemouse/spacenav_reader.h"

namespace palpate {

/// A SpaceMouse: rate control of the tool.  The person sees what happens and feels nothing, so the
/// hand stays within reach of the graphic tool (BlindHand), and stands still until there is one.
/// Where spacenavd or the device goes, it stands still with kDeviceFault, and resumes when they are
/// back.  Thread contract: as Device; a thread of its own listens to spacenavd.
class SpaceMouseDevice final : public Device {
 public:
  static constexpr double kTick_s = 1e-3;
  /// A push counts for so long: a SpaceMouse that is pushed reports 60 times a second and more, and
  /// one that is let go reports zero.  A daemon that hangs does neither.
  static constexpr double kPushLives_s = 0.3;

  /// @param start  where the tool is at first.  Throws Error as SpacenavReader does.
  explicit SpaceMouseDevice(const Pose& start);

  const DeviceInfo& info() const override { return info_; }
  DeviceSample Read() noexcept override;
  void Apply(const LimitedWrench& wrench) noexcept override;
  void SeeGraphicTool(const Pose& X_WG, const Vec3& p_HT) noexcept override {
    hand_.SeeGraphicTool(X_WG, p_HT);
  }
  void LoseGraphicTool() noexcept override { hand_.LoseGraphicTool(); }
  const char* activity() const noexcept override;

 private:
  DeviceInfo info_;
  BlindHand hand_;
  SpacenavState state_;
  double state_age_s_ = 0.0;
  bool pushed_ = false;
  SpacenavReader reader_;
};

}  // namespace palpate
