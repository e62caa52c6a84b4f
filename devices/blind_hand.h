#pragma once

#include <optional>
#include <string>
#include <utility>

#include "common/math/pose.h"
#include "devices/device.h"

namespace palpate {

/// The simulated hand of a device that renders no force.  It follows its target as a critically
/// damped spring would, at bounded speed, so that it never jumps.  Because it cannot feel that it
/// presses, it goes no further than kMaxPress_m and kMaxTwist_rad from the graphic tool, wherever
/// the target is. The target is a pose (Follow: a dragging mouse) or a velocity (Drive: a knob that
/// is pushed).
/// Real-time and deterministic: no allocation, lock, log or clock.
class BlindHand {
 public:
  static constexpr double kMaxSpeed_m_s = 0.5;  ///< of the tool's reference point
  static constexpr double kMaxTurn_rad_s = 5.0;
  static constexpr double kMaxPress_m = 0.020;   ///< 20 N at 1 N/mm
  static constexpr double kMaxTwist_rad = 0.35;  ///< 0.35 N m at 1 N m/rad

  explicit BlindHand(const Pose& X_WH) : X_WH_(X_WH) {}

  void Follow(const Pose& X_WT) noexcept {
    X_WT_ = X_WT;
    rate_.reset();
  }
  /// Moves the target at this velocity (of the tool's reference point, in W) from now on.  The
  /// target stays within reach of the graphic tool, so that a reversal acts at once.  The hand
  /// stands still until there is a graphic tool.
  void Drive(const Twist& V_WT) noexcept { rate_ = V_WT; }
  /// Lets go: the hand comes to rest at the graphic tool's present pose, so that no force remains.
  void LetGo() noexcept;
  /// Takes the graphic tool's pose from the scene's server.
  /// @param p_HT  point at which the server's wrench acts, in the tool's frame [m].
  void SeeGraphicTool(const Pose& X_WG, const Vec3& p_HT) noexcept;
  /// Ends the session.  The hand is put back to the graphic tool's last pose, and rests there until
  /// it sees the graphic tool again, so that a session that begins with a hand inside an object
  /// gives no force.  A target pose (Follow) then applies again; a distance driven by velocity
  /// (Drive) does not.
  void LoseGraphicTool() noexcept;
  /// Advances by the time h [s].
  void Step(double h) noexcept;

  const Pose& pose() const noexcept { return X_WH_; }
  /// Velocity of the handle's origin, in W.
  Twist twist() const noexcept;
  bool follows() const noexcept { return X_WT_.has_value(); }
  /// Returns true while the target is further from the graphic tool than the hand may press.
  bool held_back() const noexcept { return held_back_; }

 private:
  Pose X_WH_;
  Vec3 v_ = Vec3::Zero();  // velocity of the reference point, in W
  Vec3 w_ = Vec3::Zero();
  std::optional<Pose> X_WT_;
  std::optional<Twist> rate_;  // velocity of X_WT_
  std::optional<Pose> X_WG_;
  Vec3 p_HT_ = Vec3::Zero();
  bool held_back_ = false;
  bool lost_ = false;
};

/// A device that consists of a BlindHand.  The force that the hand can exert stays below the bounds
/// of the data sheet.
class BlindDevice : public Device {
 public:
  static constexpr double kTick_s = 1e-3;

  /// @param workspace_m  side of the cube within its reach.
  BlindDevice(std::string model, double workspace_m, const Pose& start)
      : info_(SheetWithoutForce(std::move(model), workspace_m)), hand_(start) {}

  const DeviceInfo& info() const override { return info_; }
  void Apply(const LimitedWrench&) noexcept override { hand_.Step(kTick_s); }
  void SeeGraphicTool(const Pose& X_WG, const Vec3& p_HT) noexcept override {
    hand_.SeeGraphicTool(X_WG, p_HT);
  }
  void LoseGraphicTool() noexcept override { hand_.LoseGraphicTool(); }

 protected:
  DeviceInfo info_;
  BlindHand hand_;
};

}  // namespace palpate
