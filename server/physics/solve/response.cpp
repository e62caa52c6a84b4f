#include "server/physics/solve/response.h"

#include "common/math/rotation.h"

namespace palpate {

Target TargetOf(const Vec3& p_G, const Quat& q_G, const Vec3& p_H, const Quat& q_H) noexcept {
  return {p_H - p_G, RotationLog(q_H * q_G.conjugate())};
}

Target TargetFrom(const Vec3& p_G, const Quat& q_G, const Vec3& p_H, const Quat& q_H,
                  Vec3& rotation_G) noexcept {
  Vec3 turn = q_G * rotation_G;
  const Target target{p_H - p_G, RotationLogFrom(q_H * q_G.conjugate(), turn)};
  rotation_G = q_G.conjugate() * turn;
  return target;
}

Wrench SpringWrench(const Target& target, const Vec3& v, const Vec3& phi, double stiffness,
                    double torsional_stiffness) noexcept {
  Wrench wrench;
  wrench.force = stiffness * (v - target.v);
  // R_G' R_H^T with R_G' = Exp(phi) R_G, and R_H R_G^T = Exp(phi_h).
  wrench.torque = torsional_stiffness * RotationDifference(phi, target.phi);
  return wrench;
}

}  // namespace palpate
