#include "devices/simulated/phantom_sheets.h"

#include "common/error.h"

namespace palpate {
namespace {

constexpr double kDegree = 0.017453292519943295;

// [sheet]    the maker's data sheet, named at each arm, as it is commonly quoted: to be checked
// against the sheet itself.  README.md lists the figures.
// [estimate] not in the sheet; the reason is given beside it.
// Not modelled: the linkage (mass and friction are the same in all directions), its elasticity, and
// the gimbal's stops (a scene may need whole turns).

/// The gimbal of both Premiums: encoders, motors and its dynamics, for which nothing is published.
void AddPremiumGimbal(PhantomSheet& sheet) {
  sheet.info.max_torque_Nm = 0.515;                       // [sheet] yaw and pitch
  sheet.info.continuous_torque_Nm = 0.188;                // [sheet] yaw and pitch
  sheet.info.rotation_resolution_rad = 0.0080 * kDegree;  // [sheet] roll; the others 0.0023
  sheet.dynamics.max_roll_torque_Nm = 0.170;              // [sheet] continuous 0.048
  sheet.dynamics.inertia_kg_m2 = 3e-4;      // [estimate] 0.1 kg of gimbal within 55 mm
  sheet.dynamics.coulomb_torque_Nm = 4e-3;  // [estimate] 0.2 N at a 20 mm pulley
  sheet.dynamics.viscous_Nm_s = 2e-4;       // [estimate]
}

}  // namespace

PhantomSheet PhantomPremium30() {
  // "PHANTOM Premium 3.0/6DOF": yaw 297, pitch 260, roll 335 degrees.
  PhantomSheet sheet;
  sheet.name = "premium-3.0";
  sheet.info.model = "PHANTOM Premium 3.0/6DOF (simulated)";
  sheet.info.simulated = true;
  sheet.info.max_force_N = 22.0;                       // [sheet]
  sheet.info.continuous_force_N = 3.0;                 // [sheet]
  sheet.info.workspace_m = Vec3(0.838, 0.584, 0.406);  // [sheet]
  sheet.info.position_resolution_m = 0.02e-3;          // [sheet]
  sheet.info.max_stiffness_N_m = 1000.0;               // [sheet] 1 N/mm
  sheet.dynamics.mass_kg = 0.159;                      // [sheet]
  sheet.dynamics.coulomb_force_N = 0.2;                // [sheet] backdrive friction
  sheet.dynamics.viscous_N_s_m = 0.1;  // [estimate] 0.1 N at 1 m/s: small beside dry friction
  AddPremiumGimbal(sheet);
  return sheet;
}

PhantomSheet PhantomPremium15() {
  // "PHANTOM Premium 1.5/6DOF".  The High Force version (37.5 N, 0.007 mm) is another arm, with
  // other motors and gears; for the ordinary one there are measured dynamics to compare with.
  PhantomSheet sheet;
  sheet.name = "premium-1.5";
  sheet.info.model = "PHANTOM Premium 1.5/6DOF (simulated)";
  sheet.info.simulated = true;
  sheet.info.max_force_N = 8.5;                        // [sheet]
  sheet.info.continuous_force_N = 1.4;                 // [sheet]
  sheet.info.workspace_m = Vec3(0.381, 0.267, 0.191);  // [sheet]
  sheet.info.position_resolution_m = 0.03e-3;          // [sheet] 860 dpi
  sheet.info.max_stiffness_N_m = 3500.0;               // [sheet] 3.5 N/mm
  sheet.dynamics.mass_kg = 0.136;                      // [sheet]; without the gimbal, below 0.075
  sheet.dynamics.coulomb_force_N = 0.04;               // [sheet] backdrive friction
  // [estimate] less than half of the 3.0's, with arms less than half as long.
  sheet.dynamics.viscous_N_s_m = 0.04;
  AddPremiumGimbal(sheet);
  return sheet;
}

PhantomSheet PhantomTouch() {
  // "Touch", word for word that of the "PHANTOM Omni": the gimbal has potentiometers, no motors.
  PhantomSheet sheet;
  sheet.name = "touch";
  sheet.info.model = "Touch, forces but no torque (simulated)";
  sheet.info.simulated = true;
  sheet.info.torque_axes = 0;                          // [sheet] force feedback: x, y, z
  sheet.info.max_force_N = 3.3;                        // [sheet]
  sheet.info.continuous_force_N = 0.88;                // [sheet] 24 hours
  sheet.info.workspace_m = Vec3(0.160, 0.120, 0.070);  // [sheet]
  sheet.info.position_resolution_m = 0.055e-3;         // [sheet] 450 dpi
  // [estimate] the sheet gives 5 % linearity alone: ten bits of a turn.
  sheet.info.rotation_resolution_rad = 0.35 * kDegree;
  sheet.info.max_stiffness_N_m = 1020.0;  // [sheet] along z; x 1.26 N/mm, y 2.31 N/mm
  sheet.dynamics.mass_kg = 0.045;         // [sheet]
  sheet.dynamics.coulomb_force_N = 0.26;  // [sheet] backdrive friction
  sheet.dynamics.viscous_N_s_m = 0.1;     // [estimate] small beside dry friction
  sheet.dynamics.inertia_kg_m2 = 5e-5;    // [estimate] a stylus of 0.04 kg, half of it at 50 mm
  // [estimate] the wipers of three potentiometers, 1 mN m each.
  sheet.dynamics.coulomb_torque_Nm = 3e-3;
  sheet.dynamics.viscous_Nm_s = 1e-4;  // [estimate]
  return sheet;
}

std::vector<PhantomSheet> PhantomSheets() {
  return {PhantomPremium30(), PhantomPremium15(), PhantomTouch()};
}

PhantomSheet PhantomSheetOf(const std::string& name) {
  std::string names;
  for (PhantomSheet& sheet : PhantomSheets()) {
    if (sheet.name == name) return std::move(sheet);
    names.append(names.empty() ? "" : ", ").append(sheet.name);
  }
  throw UsageError("--model " + name + ": is not an arm; give one of " + names);
}

}  // namespace palpate
