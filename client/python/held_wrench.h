#pragma once

#include <cmath>
#include <cstdint>

#include "common/math/pose.h"
#include "common/math/rotation.h"

namespace palpate {

/// The result of the last call of a force in Python, valid until the next call: a wrench on the
/// hand, at the origin of the tool's frame, in W.  If it has a stiffness, it acts as a spring
/// between calls.
struct HeldWrench {
  Wrench wrench;
  Eigen::Matrix<double, 6, 6> stiffness = Eigen::Matrix<double, 6, 6>::Zero();  ///< of [x; turn]
  Pose X_WH;                                       ///< the hand's pose at that call
  double max_force_N = 1.0, max_torque_Nm = 0.01;  ///< limits; longer vectors are shortened
  std::uint64_t every = 10;  ///< number of 1 ms steps from one call to the next

  /// Returns the wrench at the hand's present pose; zero if that is not finite.  Real-time.
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
