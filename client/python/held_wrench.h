#pragma once

#include <cmath>
#include <cstdint>

#include "common/math/pose.h"
#include "common/math/rotation.h"

namespace palpate {

/// What a force in Python said when it was last asked, until it is asked again: a wrench on the
/// hand, at the origin of the tool's frame, in W, which goes on as a spring where it has a
/// stiffness.
struct HeldWrench {
  Wrench wrench;
  Eigen::Matrix<double, 6, 6> stiffness = Eigen::Matrix<double, 6, 6>::Zero();  ///< of [x; turn]
  Pose X_WH;                                       ///< where the hand was then
  double max_force_N = 1.0, max_torque_Nm = 0.01;  ///< longer ones are shortened
  std::uint64_t every = 10;                        ///< steps of a millisecond: when it is asked

  /// Where the hand is now; nothing where that is out of all numbers.  Real-time.
  Wrench At(const Pose& X_WN) const noexcept {
    Eigen::Matrix<double, 6, 1> way;
    way << X_WN.p - X_WH.p, RotationLog((X_WN.q * X_WH.q.conjugate()).normalized());
    const Eigen::Matrix<double, 6, 1> pull = stiffness * way;
    const auto within = [](const Vec3& v, double most) -> Vec3 {
      const double length = v.stableNorm();
      if (!std::isfinite(length)) return Vec3::Zero();
      return length > most ? most / length * v : v;
    };
    return {within(wrench.force - pull.head<3>(), max_force_N),
            within(wrench.torque - pull.tail<3>(), max_torque_Nm)};
  }
};

}  // namespace palpate
