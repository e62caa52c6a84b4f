#pragma once

#include "common/math/pose.h"

namespace palpate {

// Exponential and logarithm of SO(3), computed with +, -, *, / and sqrt alone.  libm's sin, cos and
// atan2 differ in the last bit between processors (glibc picks an FMA variant at run time); these
// functions do not, so a recorded session replays to the same bits on any machine.
// Errors: none; finite in, finite out.  Real-time: no allocation, lock, log or clock.

/// Returns the unit quaternion of the rotation vector phi [rad], which may have any length.
/// Accurate to 4 ulp.
Quat RotationExp(const Vec3& phi) noexcept;

/// Returns the rotation vector phi of a unit quaternion [rad], |phi| <= pi.  q and -q give the same
/// vector, that of the shorter turn, except at exactly half a turn, where the sign of q decides.
Vec3 RotationLog(const Quat& q) noexcept;

/// Returns the shortest rotation that turns the direction of `from` into that of `to`, as a unit
/// quaternion; for opposite directions, half a turn about one of the perpendicular axes.  Both
/// vectors may have any length but zero.  Same result as Eigen's FromTwoVectors, whose singular
/// value decomposition costs every file that calls it eight seconds of compilation.
Quat RotationBetween(const Vec3& from, const Vec3& to) noexcept;

/// Returns the rotation vector of a unit quaternion, continued from `turn`, that of the previous
/// call: past half a turn it stays on the same side, where RotationLog jumps to the other.  For
/// rotations that change by less than a right angle per call.
///
/// Up to half a turn the result is that of RotationLog.  Beyond, the axis is kept, and the
/// result is the turn about that axis, limited to a full turn: near a full turn any axis would
/// fit, and the smallest motion would choose it.  Rotation across the kept axis is ignored: a
/// torque that stands for more than half a turn would drive a body that it can tip further away
/// instead of back.
/// @param q  unit quaternion.
/// @param turn  in: the previous result, zero at first.  Out: for the next call.
Vec3 RotationLogFrom(const Quat& q, Vec3& turn) noexcept;

/// Returns the rotation vector of Exp(a) Exp(b)^T if the turn from b to a, to first order a - b, is
/// at most half a turn; else a - b.
Vec3 RotationDifference(const Vec3& a, const Vec3& b) noexcept;

}  // namespace palpate
