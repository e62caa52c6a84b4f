#pragma once

#include <span>

#include "common/qp/nearest_point.h"
#include "server/physics/energy/energy.h"
#include "server/physics/simd/aligned_columns.h"

namespace palpate {

/// Minimises 1/2 |x - t|^2 + sum of energies, subject to rows a_i . x >= b_i that nothing violates.
/// The energies are convex and piecewise quadratic, so Newton's method in the 3 or 6 unknowns ends
/// on the piece that the solution is on (Qi & Sun, Math. Programming 58 (1993) 353-367).  With the
/// pieces as they are at x the sum is a quadratic, of the Hessian H = I + ... = L L^T; in y = L^T x
/// its least point is a nearest point, under the rows L^-1 a.  Where the same pieces count there,
/// that is the solution.  Where a step overshoots, a search along it ends in less (Pang & Qi, J.
/// Optim. Theory Appl. 85 (1995) 633-648), so that no cycle is possible.
/// Thresholds are taken by stages of springs (README.md).
class EnergySolver {
 public:
  /// @param rows  rigid ones at most.  Set-up.
  explicit EnergySolver(std::size_t rows) : transformed_(7, rows) {}

  /// @param unknowns  3 or 6, of t, x and rows.   @param t  target [m].
  /// @param start     where Newton's method begins; the nearer the fewer turns.
  /// @param guess     rows that were active last time, as of SolveNearestPoint.
  /// The result's active rows are rigid ones.  It is as of SolveNearestPoint; `iterations` counts
  /// the turns too.  Real-time: no allocation, lock, log or clock.  Deterministic.
  QpResult Solve(const Kernels& kernels, int unknowns, const double* t, const QpRows& rigid,
                 std::span<Energy* const> energies, const double* start,
                 std::span<const int> guess) noexcept;
  /// Of the energies, summed, at the last result [m].
  const double* force() const { return force_; }

 private:
  AlignedColumns transformed_;
  double force_[6] = {};
};

}  // namespace palpate
