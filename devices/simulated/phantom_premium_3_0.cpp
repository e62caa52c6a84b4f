#include "devices/simulated/phantom_premium_3_0.h"

namespace palpate {

// [sheet] 3D Systems (SensAble), "PHANTOM Premium 3.0/6DOF" data sheet:
//   workspace 838 x 584 x 406 mm; yaw 297, pitch 260, roll 335 degrees;
//   resolution 0.02 mm, yaw and pitch 0.0023, roll 0.0080 degrees;
//   peak force 22 N, continuous 3 N; peak torque 515 (yaw, pitch) and 170 mN m (roll),
//   continuous 188 and 48 mN m; stiffness 1 N/mm; backdrive friction 0.2 N; apparent mass 159 g.
// [estimate] everything the sheet is silent about; the reason stands beside it.
// Not modelled: the linkage (mass and friction are taken as equal in all directions), its
// stiffness, and the gimbal's stops (a scene may ask for whole turns).

DeviceInfo PhantomPremium30Info() {
  DeviceInfo info;
  info.model = "PHANTOM Premium 3.0/6DOF (simulated)";
  info.max_force_N = 22.0;                                       // [sheet]
  info.continuous_force_N = 3.0;                                 // [sheet]
  info.max_torque_Nm = 0.515;                                    // [sheet] yaw and pitch
  info.continuous_torque_Nm = 0.188;                             // [sheet] yaw and pitch
  info.workspace_m = Vec3(0.838, 0.584, 0.406);                  // [sheet]
  info.position_resolution_m = 0.02e-3;                          // [sheet]
  info.rotation_resolution_rad = 0.0080 * 0.017453292519943295;  // [sheet] roll, the coarsest
  info.simulated = true;
  return info;
}

HandleDynamics PhantomPremium30Dynamics() {
  HandleDynamics dynamics;
  dynamics.mass_kg = 0.159;             // [sheet]
  dynamics.coulomb_force_N = 0.2;       // [sheet]
  dynamics.viscous_N_s_m = 0.1;         // [estimate] 0.1 N at 1 m/s: small beside dry friction
  dynamics.inertia_kg_m2 = 3e-4;        // [estimate] 0.1 kg of gimbal within 55 mm
  dynamics.coulomb_torque_Nm = 4e-3;    // [estimate] 0.2 N at a 20 mm pulley
  dynamics.viscous_Nm_s = 2e-4;         // [estimate]
  dynamics.max_roll_torque_Nm = 0.170;  // [sheet]
  return dynamics;
}

}  // namespace palpate
