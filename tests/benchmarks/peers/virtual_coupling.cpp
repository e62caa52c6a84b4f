#include "tests/benchmarks/peers/virtual_coupling.h"

#include <cmath>

#include "common/math/rotation.h"

namespace palpate::bench {
namespace {
constexpr double kStep = 1e-3;  // [s]
}

VirtualCoupling::VirtualCoupling(const Coupling& coupling, const Pose& start)
    : coupling_(coupling),
      inertia_(kMass * coupling.torsional_stiffness / coupling.stiffness),
      damping_(2.0 * std::sqrt(coupling.stiffness * kMass)),
      torsional_damping_(2.0 * std::sqrt(coupling.torsional_stiffness * inertia_)),
      X_WH_(start) {}

void VirtualCoupling::MoveHand(const Pose& X_WH) {
  V_WH_ = {(X_WH.p - X_WH_.p) / kStep, RotationLog(X_WH.q * X_WH_.q.conjugate()) / kStep};
  X_WH_ = X_WH;
}

Wrench VirtualCoupling::Pull(const Pose& X_WG, const Twist& V_WG) {
  on_hand_ = {coupling_.stiffness * (X_WG.p - X_WH_.p),
              coupling_.torsional_stiffness * RotationLog(X_WG.q * X_WH_.q.conjugate())};
  return {damping_ * (V_WH_.v - V_WG.v) - on_hand_.force,
          torsional_damping_ * (V_WH_.w - V_WG.w) - on_hand_.torque};
}

}  // namespace palpate::bench
