#pragma once

#include <algorithm>
#include <optional>

#include "client/station/guide.h"
#include "common/math/pose.h"
#include "common/math/rotation.h"

namespace palpate {

/// Where a guide has to aim so that a station pulls a hand at rest with this wrench: a station
/// pulls in proportion to the distance, up to its whole force at Guide::kReach_m, so an aim within
/// that reach is a force.  What is more than the limits is shortened to them, direction kept.
/// None where a number is not finite.
/// @param wanted  force and torque on the hand, in W.
/// @param limits  those of the station (its --guide-force).
inline std::optional<Pose> ServoAim(const Pose& X_WH, const Wrench& wanted,
                                    const GuideLimits& limits) {
  if (!wanted.force.allFinite() || !wanted.torque.allFinite() || !(limits.force_N > 0.0)) {
    return std::nullopt;
  }
  // Beyond the reach, by a rounding error even, a guide takes a hand at rest for one that resists.
  constexpr double kWithin = 1.0 - 1e-9;
  const auto part = [](const Vec3& v, double limit, double reach) {
    const double norm = v.stableNorm();
    return Vec3(v * (kWithin * reach / std::max(norm, limit)));
  };
  const Vec3 step = part(wanted.force, limits.force_N, Guide::kReach_m);
  const Vec3 turn = part(wanted.torque, limits.torque_Nm, Guide::kReach_rad);
  return Pose{X_WH.p + step, (RotationExp(turn) * X_WH.q).normalized()};
}

}  // namespace palpate
