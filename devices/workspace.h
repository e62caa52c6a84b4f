#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "devices/device.h"

namespace palpate {

/// The placement of a device in a scene: a similarity between the device's own frame D, in which it
/// measures the handle's pose X_DH, and the scene's frame W, in which the tool has the pose X_WT.
///   p_WT = X_WD (s (p_DH - c))        q_WT = q_WD q_DH q_HT
///   v_WT = s q_WD v_DH                w_WT = q_WD w_DH
/// Force is kept, F_D = F_W, and torque is tau_D = tau_W / s, both rotated into D: then what is
/// passive in the scene is passive at the hand (README.md).  Pure; equal inputs give equal bits.
/// Real-time, except Load.
struct Workspace {
  static constexpr double kLeastScale = 0.05;
  /// At this scale a fast hand, 0.5 m/s, moves the tool at 5 m/s, the most that a server accepts.
  static constexpr double kMostScale = 10.0;

  /// c: the centre of the device's reach, in D (calibration).  Not given: D's origin; the walls are
  /// then placed around the centre that the device reports.
  std::optional<Vec3> centre_m{};
  Pose X_WD;                           ///< pose of D in W, with its origin at c
  Quat q_HT = Quat::Identity();        ///< rotation of the tool in the handle
  double scale = 1.0;                  ///< s: motion of the tool over motion of the hand
  std::optional<int> clutch_button{};  ///< while it is pressed, the tool's position is held
  /// The walls begin at this distance before the end of the device's reach ... ...
  double wall_margin_m = 0.010;
  /// ... ... and push with this force at the end; none: the device's continuous force; 0: no walls.
  std::optional<double> wall_force_N{};

  /// Reads and checks a file; README.md shows one.  Throws Error (file, line, field, remedy).
  static Workspace Load(const std::string& file);

  Pose ToScene(const Pose& X_DH) const noexcept;
  Pose ToDevice(const Pose& X_WT) const noexcept;
  Twist ToScene(const Twist& V_DH) const noexcept;
  Wrench ToScene(const Wrench& at_handle_D) const noexcept;
  Wrench ToDevice(const Wrench& at_handle_W) const noexcept;
};

/// The walls of a workspace: an elastic force back into a box, with damping that grows with the
/// depth.  Along each axis, at a depth d behind the wall and moving outwards at v:
///   F = min(F_end, F_end d / margin) x clamp(1 + v / kFadeSpeed_m_s, 0, 2)
/// So the force is zero inside, continuous everywhere, never pulls outwards, and never gives back
/// more energy than was put in: on the way out it is at least the spring's, on the way back at
/// most. (The damping is that of Hunt & Crossley, J. Applied Mechanics 42 (1975) 440-445.)
/// Real-time; pure.
class WorkspaceWalls {
 public:
  static constexpr double kFadeSpeed_m_s = 0.1;

  /// @param reach_m  size of the device's box.
  /// @param margin_m  Workspace::wall_margin_m, positive.
  WorkspaceWalls(const Vec3& centre_m, const Vec3& reach_m, double margin_m, double end_force_N);
  /// Returns the force on the handle, in D [N], at most 2 F_end along each axis.
  Vec3 Force(const Vec3& p_DH, const Vec3& v_DH) const noexcept;

 private:
  Vec3 centre_;
  Vec3 half_;  // half the size of the box inside the walls
  double margin_;
  double end_force_;
};

/// A device placed in a scene by a Workspace, with walls and a clutch (README.md says what both
/// do). When the clutch is pressed, the forces of the scene and of a guide fade out within
/// kClutchOut_s; after its release they return within kClutchIn_s.  Walls and fade act before the
/// limiter (Shape), which bounds and switches them off like all other forces.  Behind the limiter a
/// wrench is only rotated and its torque divided by the scale, and info() is in the scene's units,
/// so the device's limits remain its limits.  The limiter keeps the energy balance at the hand
/// (DeviceInfo::motion_scale); it does not count the walls' work while the clutch is pressed, but
/// the walls are passive by themselves.
class WorkspaceDevice final : public Device {
 public:
  static constexpr double kClutchOut_s = 0.050;
  static constexpr double kClutchIn_s = 0.200;

  /// Throws Error if the walls would leave nothing of the device's reach.
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
  DeviceNews Attend() override { return device_->Attend(); }

 private:
  std::unique_ptr<Device> device_;
  Workspace workspace_;
  DeviceInfo info_;
  std::optional<WorkspaceWalls> walls_;
  double tick_s_;
  DeviceSample raw_;           // the device's own sample, in D
  Vec3 shift_ = Vec3::Zero();  // offset of the tool's position due to clutching, in W
  Vec3 held_ = Vec3::Zero();   // tool position while the clutch is pressed
  bool clutched_ = false;
  double gain_ = 1.0;  // factor on the scene's forces
};

}  // namespace palpate
