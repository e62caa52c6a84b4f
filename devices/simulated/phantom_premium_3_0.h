#pragma once

#include "devices/device.h"

namespace palpate {

/// A rigid handle on a backdrivable mechanism: what a simulation needs beyond a data sheet.
struct HandleDynamics {
  double mass_kg = 0.0;          ///< apparent mass at the handle, the same in every direction
  double inertia_kg_m2 = 0.0;    ///< about the handle's origin, the same about every axis
  double coulomb_force_N = 0.0;  ///< dry friction against translation
  double viscous_N_s_m = 0.0;
  double coulomb_torque_Nm = 0.0;
  double viscous_Nm_s = 0.0;
  double max_roll_torque_Nm = 0.0;  ///< about the handle's own z axis, weaker than the other two
};

/// The device of the chapter's experiments: SensAble (now 3D Systems) PHANTOM Premium 3.0/6DOF.
DeviceInfo PhantomPremium30Info();
HandleDynamics PhantomPremium30Dynamics();

}  // namespace palpate
