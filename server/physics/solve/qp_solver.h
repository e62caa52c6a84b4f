#pragma once

#include "common/qp/nearest_point.h"
#include "server/physics/simd/kernels.h"

namespace palpate {

/// SolveNearestPoint (common/qp) by an instruction set of choice: equal bits, sooner.
/// @tparam N      3 or 6 unknowns; the first N columns are used.
/// Real-time: no allocation, lock, log or clock.  Deterministic: equal inputs, equal bits.
template <int N>
QpResult SolveNearestPoint(const Kernels& kernels, const double* t, const QpRows& rows,
                           const int* guess, int guesses) noexcept {
  static_assert(N == 3 || N == 6);
  return (N == 6 ? kernels.solve_6 : kernels.solve_3)(t, rows, guess, guesses);
}

/// Minimises 1/2 |x - t|^2 + sum eta_i^2 / (2 c_i) subject to a_i . x + eta_i >= b_i for soft rows,
/// weight w_i = 1 / c_i, and a_i . x >= b_i for rigid ones: a diagonal in the dual.  Any
/// number of soft rows may yield at once, so they are not taken up one by one: they are a convex,
/// piecewise quadratic energy, minimised by Newton's method in the N unknowns, a pass over the rows
/// a turn (simd/compliant.inl).  The result's active rows are the rigid ones; a soft row's force is
/// w_i (soft_b_i - a_i . x) where that is positive.  Else as SolveNearestPoint.
template <int N>
QpResult SolveCompliant(const Kernels& kernels, const double* t, const CompliantRows& rows,
                        const int* guess, int guesses) noexcept {
  static_assert(N == 3 || N == 6);
  return (N == 6 ? kernels.solve_compliant_6 : kernels.solve_compliant_3)(t, rows, guess, guesses);
}

}  // namespace palpate
