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

}  // namespace palpate
