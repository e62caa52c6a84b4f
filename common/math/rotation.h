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

/// Rotation vector of a unit quaternion that goes on from `turn`, that of a moment ago: past half a
/// turn it stays on the side that it came from, where RotationLog leaps to the other one.  For
/// rotations that change by less than a right angle from call to call.
///
/// Up to half a turn it is RotationLog.  Beyond, the axis is kept, and the result is the turn about
/// it, but a full one at most: near that every axis would do, and a tremble would choose.  What the
/// rotation does across the axis is left out: a pull that is longer than half a turn drives a body
/// that it can tip further from where it is, not back.
/// @param q  as RotationLog takes it.   @param turn  in: zero where nothing came before.  Out: for
/// the next call.
Vec3 RotationLogFrom(const Quat& q, Vec3& turn) noexcept;

/// Rotation vector of Exp(a) Exp(b)^T, where the way from b to a, a - b to first order, is not
/// beyond half a turn; a - b where it is.
Vec3 RotationDifference(const Vec3& a, const Vec3& b) noexcept;

}  // namespace palpate
