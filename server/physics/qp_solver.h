#pragma once

#include "server/physics/simd/kernels.h"

namespace palpate {

/// Minimises 1/2 |x - t|^2 subject to a_i . x >= b_i: the point of a polyhedron nearest to t.
/// Dual active set after Goldfarb & Idnani, Math. Programming 27 (1983) 1-33, with the Hessian the
/// identity (simd/dual_active_set.inl).  It starts from t itself, so it needs no feasible start
/// (the limitation that chapter 2.3.3 ends with), and stops where no row is violated by more than
/// rounding.
///
/// Contradictory rows have no solution.  They are then solved once more as
///   minimise 1/2 |x - t|^2 + eta^2 / (2 c)  subject to  a_i . x + eta >= b_i,  c = kJamCompliance,
/// the same method with one unknown more.  A compliance on every row would do too, but there a
/// thousand copies of a row are a thousand active rows; here they are one.
///
/// @tparam N      3 or 6 unknowns; the first N columns are used.
/// @param t       target [unit of b].
/// @param rows    any count, all finite.  Duplicates, parallels and zero rows are allowed.
/// @param guess   rows that were active last time, most useful first; may repeat; not required.
/// Real-time: no allocation, lock, log or clock.  Deterministic: equal inputs, equal bits.
template <int N>
QpResult SolveNearestPoint(const Kernels& kernels, const double* t, const QpRows& rows,
                           const int* guess, int guesses) noexcept {
  static_assert(N == 3 || N == 6);
  return (N == 6 ? kernels.solve_6 : kernels.solve_3)(t, rows, guess, guesses);
}

/// Minimises 1/2 |x - t|^2 + sum eta_i^2 / (2 c_i) subject to a_i . x + eta_i >= b_i for soft rows,
/// weight w_i = 1 / c_i, and a_i . x >= b_i for rigid ones: METHOD's diagonal in the dual.  Any
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

/// Compliance of a jam, as a ratio to the coupling's 1/k_t: with 1000 N/m it stands for 10^8 N/m,
/// about that of enamel on steel.
inline constexpr double kJamCompliance = 1e-5;

}  // namespace palpate
