#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "devices/device.h"

namespace palpate {

/// The dynamics of a rigid handle on a backdrivable mechanism, which a simulation needs
/// beyond DeviceInfo.
struct HandleDynamics {
  double mass_kg = 0.0;          ///< apparent mass at the handle, the same in every direction
  double inertia_kg_m2 = 0.0;    ///< about the handle's origin, the same about every axis
  double coulomb_force_N = 0.0;  ///< dry friction against translation
  double viscous_N_s_m = 0.0;
  double coulomb_torque_Nm = 0.0;
  double viscous_Nm_s = 0.0;
  double max_roll_torque_Nm = 0.0;  ///< about the handle's own z axis, weaker than the other two
};

/// The data sheet of an arm of the PHANTOM family.  The .cpp cites the source of each figure.
struct PhantomSheet {
  std::string_view name;  ///< the argument of --model
  DeviceInfo info;
  HandleDynamics dynamics;
};

/// SensAble (now 3D Systems) PHANTOM Premium 3.0/6DOF, the device in the chapter's experiments.
PhantomSheet PhantomPremium30();
/// PHANTOM Premium 1.5/6DOF.
PhantomSheet PhantomPremium15();
/// Touch, formerly PHANTOM Omni: senses six axes and drives three, so it renders no torque.
PhantomSheet PhantomTouch();

/// Returns all sheets, the default first.
std::vector<PhantomSheet> PhantomSheets();
/// Returns a sheet by its name; throws UsageError, which lists the valid names.
PhantomSheet PhantomSheetOf(const std::string& name);

}  // namespace palpate
