#pragma once

#include <limits>

#include "devices/device.h"

namespace palpate {

/// The bounds of a WrenchLimiter: those of the data sheet or less, never more.  Force and torque
/// are bounded by their norms.
class WrenchLimits {
 public:
  struct Bounds {
    double force_N = 0.0;  ///< peak
    double torque_Nm = 0.0;
    double continuous_force_N = 0.0;  ///< what remains when the motors are warm
    double continuous_torque_Nm = 0.0;
    /// Bounds on the change of the *output*, all stages together.
    double force_slew_N_per_ms = 0.0;
    double torque_slew_Nm_per_ms = 0.0;
    /// Bounds on what a guide adds, within the peak; low, so that a hand can always overrule it.
    double led_force_N = 0.0;
    double led_torque_Nm = 0.0;
  };

  /// Returns the limits of a device.  The whole peak may appear or vanish in 5 ms, 4.4 N/ms for 22
  /// N.  A hand that hits 1 N/mm at 0.5 m/s needs 0.5 N/ms, so touches are never softened, but
  /// jumps are.
  /// @param device  its data sheet.
  /// @param most_force_N  if it is less than the device's peak, it replaces the peak, and the
  /// torque's peak is reduced by the same factor.
  /// Throws Error if a figure is missing or invalid.
  static WrenchLimits Of(const DeviceInfo& device,
                         double most_force_N = std::numeric_limits<double>::infinity());

  const Bounds& bounds() const noexcept { return bounds_; }
  double force_N() const noexcept { return bounds_.force_N; }
  double torque_Nm() const noexcept { return bounds_.torque_Nm; }
  double continuous_force_N() const noexcept { return bounds_.continuous_force_N; }
  double continuous_torque_Nm() const noexcept { return bounds_.continuous_torque_Nm; }
  double force_slew_N_per_ms() const noexcept { return bounds_.force_slew_N_per_ms; }
  double torque_slew_Nm_per_ms() const noexcept { return bounds_.torque_slew_Nm_per_ms; }
  double thermal_time_s() const noexcept { return thermal_time_s_; }
  double motion_scale() const noexcept { return motion_scale_; }
  double position_resolution_m() const noexcept { return position_resolution_m_; }
  double rotation_resolution_rad() const noexcept { return rotation_resolution_rad_; }

  /// The greatest rate of change of each stage's output [N/s, N m/s], chosen so that their sum
  /// keeps the slew limit (proof in wrench_limiter.h).
  struct Rates {
    double contact_force, contact_torque;
    double led_force, led_torque;
  };
  Rates rates() const noexcept;

 private:
  WrenchLimits() = default;

  Bounds bounds_;
  double thermal_time_s_ = 0.0;
  double motion_scale_ = 1.0;
  double position_resolution_m_ = 0.0;
  double rotation_resolution_rad_ = 0.0;
};

}  // namespace palpate
