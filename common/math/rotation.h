#pragma once

#include "common/math/pose.h"

namespace palpate {

// Exponential and logarithm of SO(3) from +, -, *, / and sqrt alone.  libm's sin, cos and atan2
// differ in the last bit between processors (glibc picks an FMA variant at run time); these do not,
// so a recorded session replays to the same bits anywhere.
// Errors: none; finite in, finite out.  Real-time: no allocation, lock, log or clock.

/// Unit quaternion of the rotation vector phi [rad], any length.  Accurate to 4 ulp.
Quat RotationExp(const Vec3& phi) noexcept;

/// Rotation vector of a unit quaternion, |phi| <= pi.  q and -q give the same vector (the shorter
/// way round), except at exactly half a turn, where both are shortest and the sign of q decides.
Vec3 RotationLog(const Quat& q) noexcept;

/// The shortest rotation that takes the direction of `from` to that of `to`, unit quaternion; of
/// opposite ones half a turn about one of the axes across.  Both of any length but zero.  As
/// Eigen's FromTwoVectors, whose singular value decomposition costs every file that calls it eight
/// seconds of compilation.
Quat RotationBetween(const Vec3& from, const Vec3& to) noexcept;

}  // namespace palpate
