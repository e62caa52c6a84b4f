#include "devices/simulated/simulated_hand.h"

#include "common/math/rotation.h"

namespace palpate {

Wrench SimulatedHand::WrenchOn(const Pose& X_WH, const Twist& V_WH, double t) const noexcept {
  const Pose wanted = script_.At(t);
  const Twist moving = script_.VelocityAt(t);
  return {impedance_.stiffness_N_m * (wanted.p - X_WH.p) +
              impedance_.damping_N_s_m * (moving.v - V_WH.v),
          impedance_.stiffness_Nm_rad * RotationLog(wanted.q * X_WH.q.conjugate()) +
              impedance_.damping_Nm_s * (moving.w - V_WH.w)};
}

}  // namespace palpate
