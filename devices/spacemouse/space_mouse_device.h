#pragma once

#include <array>

#include "common/math/pose.h"
#include "devices/blind_hand.h"
#include "devices/device.h"
#include "devices/spacemouse/spacenav_reader.h"

namespace palpate {

/// Rate control: the deflection of a SpaceMouse's cap determines the tool's velocity.  Per axis the
/// speed is zero inside a dead band, so that a resting hand, or crosstalk from a push along another
/// axis, moves nothing; then it rises along a curve that starts gently, and reaches the top speed
/// at full deflection.  The greatest velocity of all axes together, 0.35 m/s and 2.6 rad/s, is
/// within the limits of BlindHand, which are within what a server accepts (5 m/s, 100 rad/s).
struct RateControl {
  static constexpr double kFullDeflection = 350.0;  ///< counts; spacenavd's own full scale
  static constexpr double kDeadBand = 20.0;         ///< counts
  static constexpr double kTopSpeed_m_s = 0.2;
  static constexpr double kTopTurn_rad_s = 1.5;

  /// Returns the share of the top speed, in [-1, 1]: the square of the deflection beyond the dead
  /// band, continuous and odd.
  static double Share(double counts) noexcept;

  /// Returns the velocity in the device's frame, which is right-handed: x right, y up, z towards
  /// the user.
  /// @param axes  x, y, z, rx, ry, rz as spacenavd gives them: x right, y up, z away from the user.
  static Twist Velocity(const std::array<int, 6>& axes) noexcept;
};

/// A SpaceMouse, which controls the tool's velocity.  The user sees what happens but feels nothing,
/// so the hand stays within reach of the graphic tool (BlindHand), and stands still until there is
/// one. If spacenavd or the device disappears, it stands still with kDeviceFault, and resumes when
/// they are back.  Thread contract: as Device; a thread of its own listens to spacenavd.
class SpaceMouseDevice final : public BlindDevice {
 public:
  /// The time for which a report of a push remains valid.  A SpaceMouse that is pushed reports
  /// at least 60 times a second, and one that is released reports zero; a daemon that hangs
  /// does neither.
  static constexpr double kPushLives_s = 0.3;

  /// @param start  initial pose of the tool.
  /// Throws Error as SpacenavReader does.
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
