#pragma once

#include <optional>

#include "common/math/pose.h"
#include "devices/device.h"
#include "devices/script_player.h"
#include "devices/simulated/phantom_sheets.h"

namespace palpate {

/// Mechanical impedance of a human arm and hand that hold a handle, the same in every direction.
struct HandImpedance {
  // One participant's fit, perpendicular to the arm: van Beek, Bergmann Tiest, Mugge & Kappers,
  // "Haptic perception of force magnitude and its relation to postural arm dynamics in 3D",
  // Scientific Reports 5 (2015) 18004, Fig. 3.
  double mass_kg = 0.554;
  double damping_N_s_m = 6.45;
  double stiffness_N_m = 135.0;
  // [estimate] A fist of 0.4 kg within 50 mm, and a relaxed wrist (passive stiffness about 1 N
  // m/rad); the damping ratio is one half.
  double inertia_kg_m2 = 1e-3;
  double damping_Nm_s = 0.036;
  double stiffness_Nm_rad = 1.0;
};

/// A hand that follows a script: a spring and a damper between the script's pose and the handle's
/// pose. Its mass is attached to the handle (the integrator must add it to the handle's).
class SimulatedHand {
 public:
  SimulatedHand(ScriptPlayer script, const HandImpedance& impedance)
      : script_(std::move(script)), impedance_(impedance) {}

  /// Returns the wrench of the hand on the handle, at the handle's origin, in W.
  /// Real-time; deterministic.
  Wrench WrenchOn(const Pose& X_WH, const Twist& V_WH, double t) const noexcept;

  const HandImpedance& impedance() const { return impedance_; }
  const ScriptPlayer& script() const { return script_; }

 private:
  ScriptPlayer script_;
  HandImpedance impedance_;
};

namespace test {
class PastTheLimiter;  // tests/support: for measurements of the limiter's effect
}

/// A simulated haptic device: a rigid handle with mass, friction, motors that saturate, encoders
/// that quantise and a bounded workspace, held by a simulated hand or free.  Each Apply advances by
/// one period of its rate, in sub-steps of at most kSubstep_s (semi-implicit Euler; friction is
/// implicit, so that it stops a handle and never drives it).  Time is a count of ticks, so a run
/// repeats bit for bit. The mechanism is balanced: no gravity.
class SimulatedPhantom final : public Device {
 public:
  static constexpr double kSubstep_s = 0.125e-3;
  static constexpr double kMaxRate_Hz = 4000.0;

  /// @param hand  none: the handle floats freely, starting at X_WH.
  /// Throws Error if the sheet's rate is not within 100 Hz to kMaxRate_Hz.
  SimulatedPhantom(const PhantomSheet& sheet, std::optional<SimulatedHand> hand, const Pose& X_WH);

  const DeviceInfo& info() const override { return info_; }
  /// Returns the pose that the encoders measure, and the velocity that a driver estimates from it.
  DeviceSample Read() noexcept override;
  void Apply(const LimitedWrench& wrench) noexcept override;
  const char* activity() const noexcept override;

  // The true state, without encoders, for tests and displays.
  const Pose& pose() const noexcept { return X_WH_; }
  const Twist& velocity() const noexcept { return V_WH_; }
  double time() const noexcept { return tick_s_ * static_cast<double>(ticks_); }
  double kinetic_energy_J() const noexcept;

 private:
  friend class test::PastTheLimiter;
  /// Advances by one tick, as Apply does, under any wrench.
  void Pass(const Wrench& commanded) noexcept;
  Pose Encoded() const noexcept;
  Wrench MotorWrench(const Wrench& commanded) const noexcept;
  void Substep(const Wrench& motor, double t, double h) noexcept;

  DeviceInfo info_;
  HandleDynamics dynamics_;
  double tick_s_;
  int substeps_;
  double velocity_share_;  // weight of a new encoder difference in the estimate
  std::optional<SimulatedHand> hand_;
  double mass_;     // of handle and hand [kg]
  double inertia_;  // [kg m^2]
  Pose X_WH_;
  Twist V_WH_;
  long long ticks_ = 0;
  Pose encoded_;       // at the last Apply
  Twist estimated_V_;  // from encoder differences
};

}  // namespace palpate
