#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "devices/device.h"

namespace palpate {

/// How a device lies in a scene: a similarity between the device's own frame D, in which it gives
/// the handle's pose X_DH, and the scene's W, in which the tool is X_WT.
///   p_WT = X_WD (s (p_DH - c))        q_WT = q_WD q_DH q_HT
///   v_WT = s q_WD v_DH                w_WT = q_WD w_DH
/// Force is rendered as the scene has it, F_D = F_W, and torque as tau_D = tau_W / s, both turned:
/// what is passive in the scene is passive in the hand (README.md).  Pure; equal inputs give equal
/// bits.  Real-time, but for Load.
struct Workspace {
  static constexpr double kLeastScale = 0.05;
  /// At 0.5 m/s, a fast hand, the tool moves at the 5 m/s that a server accepts.
  static constexpr double kMostScale = 10.0;

  /// c: the middle of the device's reach, in D (calibration); not given: D's origin, while the
  /// walls stand where the device says that it reaches.
  std::optional<Vec3> centre_m{};
  Pose X_WD;                           ///< where the middle comes to lie, and how D is turned
  Quat q_HT = Quat::Identity();        ///< how the tool is turned in the handle
  double scale = 1.0;                  ///< s: motion of the tool over motion of the hand
  std::optional<int> clutch_button{};  ///< while it is down, the tool's position stands still
  /// Walls begin so far inside the end of the device's reach ...
  double wall_margin_m = 0.010;
  /// ... and push with so much at the end itself; none: the device's continuous force; 0: no walls.
  std::optional<double> wall_force_N{};

  /// Reads a file, checked: README.md shows one.  Throws Error (file, line, field, remedy).
  static Workspace Load(const std::string& file);

  Pose ToScene(const Pose& X_DH) const noexcept;
  Pose ToDevice(const Pose& X_WT) const noexcept;
  Twist ToScene(const Twist& V_DH) const noexcept;
  Wrench ToScene(const Wrench& at_handle_D) const noexcept;
  Wrench ToDevice(const Wrench& at_handle_W) const noexcept;
};

/// The walls of a workspace: an elastic push back into a box, and damping that grows with the
/// depth. Along each axis, at a depth d behind the wall and moving outwards at v,
///   F = min(F_end, F_end d / margin) x clamp(1 + v / kFadeSpeed_m_s, 0, 2)
/// so it is zero inside, continuous everywhere, never pulls outwards, and never gives back more
/// than was put in: on the way out it is at least the spring's, on the way back at most. (The
/// damping is that of Hunt & Crossley, J. Applied Mechanics 42 (1975) 440-445.) Real-time; pure.
class WorkspaceWalls {
 public:
  static constexpr double kFadeSpeed_m_s = 0.1;

  /// @param reach_m  size of the device's box.   @param margin_m  as above, positive.
  WorkspaceWalls(const Vec3& centre_m, const Vec3& reach_m, double margin_m, double end_force_N);
  /// Force on the handle, in D [N], at most 2 F_end along each axis.
  Vec3 Force(const Vec3& p_DH, const Vec3& v_DH) const noexcept;

 private:
  Vec3 centre_;
  Vec3 half_;  // of the box inside the walls
  double margin_;
  double end_force_;
};

/// A device as a scene sees it through a Workspace, with walls and a clutch.
/// README.md says what both do.  What the scene and a guide press with fades out within
/// kClutchOut_s as the clutch is held, and comes back within kClutchIn_s.  Walls and fade come
/// before the limiter (Shape), which bounds and switches them off like all else; behind it, a
/// wrench is only turned and its torque divided by the scale, and info() is in the scene's units,
/// so that the device's limits stay its limits.  The limiter's energy account is the hand's own
/// (DeviceInfo::motion_scale), and blind to what the walls do while the clutch is held; they are
/// passive by themselves.
class WorkspaceDevice final : public Device {
 public:
  static constexpr double kClutchOut_s = 0.050;
  static constexpr double kClutchIn_s = 0.200;

  /// Throws Error where the walls would leave nothing of the device's reach.
  WorkspaceDevice(std::unique_ptr<Device> device, const Workspace& workspace);

  const DeviceInfo& info() const override { return info_; }
  DeviceSample Read() noexcept override;
  void Shape(Wrench& contact, Wrench& led) noexcept override;
  void Apply(const LimitedWrench& wrench) noexcept override;
  void SeeGraphicTool(const Pose& X_WG, const Vec3& p_HT) noexcept override;
  void LoseGraphicTool() noexcept override { device_->LoseGraphicTool(); }
  bool ended() const noexcept override { return device_->ended(); }
  const char* activity() const noexcept override;
  bool StartTicks(std::function<void()> tick) override {
    return device_->StartTicks(std::move(tick));
  }
  void StopTicks() override { device_->StopTicks(); }
  std::string Attend() override { return device_->Attend(); }

 private:
  std::unique_ptr<Device> device_;
  Workspace workspace_;
  DeviceInfo info_;
  std::optional<WorkspaceWalls> walls_;
  double tick_s_;
  DeviceSample raw_;           // as the device gave it, in D
  Vec3 shift_ = Vec3::Zero();  // what clutching has added to the tool's position, in W
  Vec3 held_ = Vec3::Zero();   // where the tool stands while the clutch is held
  bool clutched_ = false;
  double gain_ = 1.0;  // of what the scene presses with
};

}  // namespace palpate
