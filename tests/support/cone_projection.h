#pragma once

#include <span>

#include <Eigen/Core>

namespace palpate::test {

using Vec6L = Eigen::Matrix<long double, 6, 1>;

/// Returns what the loads x >= 0 leave of b: b - A x, with the generators a_i as columns of A, for
/// the loads that make |b - A x|^2 + slack^2 |x|^2 least.
///
/// Without slack this is non-negative least squares.  With it, directions count as known to
/// `slack`: two generators that all but oppose each other bear what lies across them only if they
/// meet at a greater angle; else rounding would make a self-locking wedge of two parallel walls.
/// Of what the generators bear, slack^2 |x| is left, a millionth for a milliradian.
///
/// The dual has six unknowns, however many generators: what is left, r, minimises
///   |r - b|^2 / 2 + sum_i max(0, a_i . r)^2 / (2 slack^2),  with  x_i = max(0, a_i . r) / slack^2,
/// a convex function, quadratic piece by piece, which Newton's method minimises in finitely many
/// steps.
/// @param generators  of length 1.
Vec6L LeftOfCone(std::span<const Vec6L> generators, const Vec6L& b, long double slack = 1e-3L);

}  // namespace palpate::test
