#pragma once

#include "common/math/pose.h"
#include "devices/script_player.h"

namespace palpate {

/// Mechanical impedance of an arm and hand that hold a handle, the same in every direction.
struct HandImpedance {
  // One participant's fit, perpendicular to the arm: van Beek, Bergmann Tiest, Mugge & Kappers,
  // "Haptic perception of force magnitude and its relation to postural arm dynamics in 3D",
  // Scientific Reports 5 (2015) 18004, Fig. 3.
  double mass_kg = 0.554;
  double damping_N_s_m = 6.45;
  double stiffness_N_m = 135.0;
  // [estimate] A fist of 0.4 kg within 50 mm, and a wrist that is not held stiff (passive stiffness
  // about 1 N m/rad); the damping gives half of critical.
  double inertia_kg_m2 = 1e-3;
  double damping_Nm_s = 0.036;
  double stiffness_Nm_rad = 1.0;
};

/// A hand that wants to follow a script: a spring and a damper from where the script is to where
/// the handle is.  Its mass rides on the handle (whoever integrates adds it to the handle's).
class SimulatedHand {
 public:
  SimulatedHand(ScriptPlayer script, const HandImpedance& impedance)
      : script_(std::move(script)), impedance_(impedance) {}

  /// Wrench of the hand on the handle, at the handle's origin, in W.  Real-time; deterministic.
  Wrench WrenchOn(const Pose& X_WH, const Twist& V_WH, double t) const noexcept;

  const HandImpedance& impedance() const { return impedance_; }
  const ScriptPlayer& script() const { return script_; }

 private:
  ScriptPlayer script_;
  HandImpedance impedance_;
};

}  // namespace palpate
