#pragma once

#include <optional>
#include <string>
#include <utility>

#include "common/math/pose.h"
#include "devices/device.h"

namespace palpate {

/// The hand behind a device that renders no force.  It follows where it is drawn to as a critically
/// damped spring would, at bounded speed, so that it never jumps.  It cannot feel that it presses;
/// so it presses no deeper than kMaxPress_m and kMaxTwist_rad from the graphic tool, wherever it is
/// drawn. It is drawn to places (Follow: a mouse that drags) or at a velocity (Drive: a knob that
/// is pushed). Real-time and deterministic: no allocation, lock, log or clock.
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
  /// Where it is drawn to moves at this velocity, of the tool's reference point, in W, from now on,
  /// and stays within reach of the graphic tool: who turns back does not have to come back first.
  /// Until there is a graphic tool, it stands still.
  void Drive(const Twist& V_WT) noexcept { rate_ = V_WT; }
  /// Lets go: the hand comes to rest where the graphic tool is now, so that no force is left.
  void LetGo() noexcept;
  /// What the scene's server says of the graphic tool.
  /// @param p_HT  point that the server's wrench acts at, in the tool's frame [m].
  void SeeGraphicTool(const Pose& X_WG, const Vec3& p_HT) noexcept;
  /// The session has ended.  The hand is put back to where the graphic tool was, and rests there
  /// until it sees that again: a session that begins with a hand inside an object gives no force.
  /// A place that it was drawn to counts again then; how far it was driven does not.
  void LoseGraphicTool() noexcept;
  /// Lets a time pass [s].
  void Step(double h) noexcept;

  const Pose& pose() const noexcept { return X_WH_; }
  /// Of the handle's origin, in W.
  Twist twist() const noexcept;
  bool follows() const noexcept { return X_WT_.has_value(); }
  /// True while it is drawn farther from the graphic tool than it may press.
  bool held_back() const noexcept { return held_back_; }

 private:
  Pose X_WH_;
  Vec3 v_ = Vec3::Zero();  // of the reference point, in W
  Vec3 w_ = Vec3::Zero();
  std::optional<Pose> X_WT_;
  std::optional<Twist> rate_;  // of X_WT_
  std::optional<Pose> X_WG_;
  Vec3 p_HT_ = Vec3::Zero();
  bool held_back_ = false;
  bool lost_ = false;
};

/// A device that is one.  What the hand can press stays below the bounds of its sheet.
class BlindDevice : public Device {
 public:
  static constexpr double kTick_s = 1e-3;

  /// @param workspace_m  side of the cube that it reaches.
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
