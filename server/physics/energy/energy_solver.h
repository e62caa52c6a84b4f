#pragma once

#include <memory>
#include <span>

#include "common/qp/nearest_point.h"
#include "server/physics/energy/energy.h"
#include "server/physics/simd/aligned_columns.h"

namespace palpate {

/// Minimises 1/2 |x - t|^2 + sum of energies, subject to rigid rows a_i . x >= b_i, by Newton's
/// method in the 6 unknowns (README.md).
class EnergySolver {
 public:
  /// @param rigid       most rigid rows.   @param thresholds  most rows with thresholds.  Set-up.
  EnergySolver(std::size_t rigid, std::size_t thresholds)
      : columns_(8, rigid + thresholds + 2 * 16),
        at_limit_(std::make_unique<bool[]>(rigid + thresholds + 2 * 16)) {}

  /// @param t      target [m].
  /// @param start  where Newton's method begins; a nearer start takes fewer iterations
  /// @param guess  rows that were active last time, as for SolveNearestPoint
  /// The result is as of SolveNearestPoint, with rigid active rows; `iterations` includes
  /// Newton's.  Real-time: no allocation, lock, log or clock.  Deterministic.
  QpResult Solve(const Kernels& kernels, const double* t, const QpRows& rigid,
                 std::span<Energy* const> energies, const double* start,
                 std::span<const int> guess) noexcept;

 private:
  AlignedColumns columns_;
  std::unique_ptr<bool[]> at_limit_;
};

}  // namespace palpate
