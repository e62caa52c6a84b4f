#pragma once

#include <optional>

#include "common/math/pose.h"

namespace palpate {

/// The rotation nearest to a matrix that is one but for noise, in the Frobenius norm: the
/// orthogonal factor of its polar decomposition, by Newton's iteration (Higham, SIAM J. Sci. Stat.
/// Comput. 7 (1986) 1160-1174).  Nothing where the matrix is farther than 0.1 from it, mirrors, or
/// is not finite: that is no noise.  Real-time.  Deterministic: +, -, *, / alone.
std::optional<Mat3> NearestRotation(const Mat3& matrix) noexcept;

}  // namespace palpate
