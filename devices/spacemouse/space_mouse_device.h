#pragma once

#include <array>

#include "common/math/pose.h"
#include "devices/blind_hand.h"
#include "devices/device.h"
#include "devices/spacemouse/spacenav_reader.h"

namespace palpate {

/// Rate control: how far the cap of a SpaceMouse is pushed says how fast the tool moves.
/// Per axis: nothing inside a dead band, so that a hand at rest and the crosstalk of a push along
/// another axis move nothing; from there a curve, fine at first; the top speed at full deflection
/// and beyond.  The largest velocity of all axes together, 0.35 m/s and 2.6 rad/s, is within what
/// the hand behind it moves at (BlindHand), which is within what a server accepts (5 m/s, 100
/// rad/s).
struct RateControl {
  static constexpr double kFullDeflection = 350.0;  ///< counts; spacenavd's own full scale
  static constexpr double kDeadBand = 20.0;         ///< counts
  static constexpr double kTopSpeed_m_s = 0.2;
  static constexpr double kTopTurn_rad_s = 1.5;

  /// Share of the top speed, in [-1, 1], continuous and odd: the square of the deflection behind
  /// the dead band.
  static double Share(double counts) noexcept;

  /// Velocity in the device's frame, which is right-handed: x right, y up, z towards the person.
  /// @param axes  x, y, z, rx, ry, rz as spacenavd gives them: x right, y up, z away from them.
  static Twist Velocity(const std::array<int, 6>& axes) noexcept;
};

/// A SpaceMouse: rate control of the tool.  The person sees what happens and feels nothing, so the
/// hand stays within reach of the graphic tool (BlindHand), and stands still until there is one.
/// Where spacenavd or the device goes, it stands still with kDeviceFault, and resumes when they are
/// back.  Thread contract: as Device; a thread of its own listens to spacenavd.
class SpaceMouseDevice final : public BlindDevice {
 public:
  /// A push counts for so long: a SpaceMouse that is pushed reports 60 times a second and more, and
  /// one that is let go reports zero.  A daemon that hangs does neither.
  static constexpr double kPushLives_s = 0.3;

  /// @param start  where the tool is at first.  Throws Error as SpacenavReader does.
  explicit SpaceMouseDevice(const Pose& start);

  DeviceSample Read() noexcept override;
  void Apply(const LimitedWrench& wrench) noexcept override;
  const char* activity() const noexcept override;

 private:
  SpacenavState state_;
  double state_age_s_ = 0.0;
  bool pushed_ = false;
  SpacenavReader reader_;
};

}  // namespace palpate
