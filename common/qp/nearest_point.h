#pragma once

#include <cstddef>
#include <span>

namespace palpate {

/// Rows a_i . x >= b_i by columns, which start 64-byte aligned; `count` is what they hold, and
/// storage goes on to the next multiple of 16 with rows that always hold (a = 0, b = -1e300).
struct QpRows {
  const double* a[6];
  const double* b;
  int count;
};

enum class QpStatus {
  kSolved,
  kRelaxed,         ///< rows contradict each other; solved with one slack common to all rows
  kIterationLimit,  ///< did not end; the result is the best point so far
};

inline constexpr int kMaxActiveRows = 7;  ///< six unknowns, and the slack of a relaxed problem

struct QpResult {
  double x[6];
  double slack = 0.0;  ///< least common violation of the rows [unit of b]; 0 unless kRelaxed
  int active = 0;
  int row[kMaxActiveRows];
  double multiplier[kMaxActiveRows];  ///< >= 0
  int iterations = 0;                 ///< rows taken up or dropped
  QpStatus status = QpStatus::kSolved;

  std::span<const int> ActiveRows() const { return {row, static_cast<std::size_t>(active)}; }
};

/// Compliance of a jam, as a ratio to the coupling's 1/k_t: with 1000 N/m it stands for 10^8 N/m,
/// about that of enamel on steel.
inline constexpr double kJamCompliance = 1e-5;

/// Minimises 1/2 |x - t|^2 subject to a_i . x >= b_i: the point of a polyhedron nearest to t.
/// Dual active set after Goldfarb & Idnani, Math. Programming 27 (1983) 1-33, with the Hessian the
/// identity (dual_active_set.inl).  It starts from t itself, so it needs no feasible start (the
/// limitation that chapter 2.3.3 ends with), and stops where no row is violated by more than
/// rounding.
///
/// Contradictory rows have no solution.  They are then solved once more as
///   minimise 1/2 |x - t|^2 + eta^2 / (2 c)  subject to  a_i . x + eta >= b_i,  c = kJamCompliance,
/// the same method with one unknown more.  A compliance on every row would do too, but there a
/// thousand copies of a row are a thousand active rows; here they are one.
///
/// @param t       6 x 1, target [unit of b].
/// @param rows    any count, all finite.  Duplicates, parallels and zero rows are allowed; one
///                shorter than 1e-75 is a zero row.
/// @param guess,guesses  rows that were active last time, most useful first; may repeat.
/// Plain C++; for many rows Kernels::solve (server/physics/simd) has it by the processor's widest
/// vectors.
/// Real-time: no allocation, lock, log or clock.  Deterministic: equal inputs, equal bits.
QpResult SolveNearestPoint(const double* t, const QpRows& rows, const int* guess,
                           int guesses) noexcept;

}  // namespace palpate
