#pragma once

#include <cstddef>
#include <span>

namespace palpate {

/// Rows a_i . x >= b_i of N unknowns, stored by column; columns are 64-byte aligned.  `count` is
/// the number of rows; storage is padded to the next multiple of 16 with rows that always hold
/// (a = 0, b = -1e300).
template <int N>
struct QpRowsOf {
  const double* a[N];
  const double* b;
  int count;
};
using QpRows = QpRowsOf<6>;

enum class QpStatus {
  kSolved,
  kRelaxed,         ///< rows contradict each other; solved with one slack common to all rows
  kIterationLimit,  ///< not converged; the result is the best point so far
};

inline constexpr int kMaxActiveRows = 7;  ///< six unknowns and the slack of a relaxed problem

template <int N>
struct QpResultOf {
  double x[N];
  double slack = 0.0;  ///< least common violation of the rows [unit of b]; 0 unless kRelaxed
  int active = 0;
  int row[N + 1];
  double multiplier[N + 1];  ///< >= 0
  int iterations = 0;        ///< number of rows added or dropped
  QpStatus status = QpStatus::kSolved;

  std::span<const int> ActiveRows() const { return {row, static_cast<std::size_t>(active)}; }
};
using QpResult = QpResultOf<6>;

/// Compliance of a jam, as a ratio to the coupling's 1/k_t: with 1000 N/m it stands for 10^8 N/m,
/// about that of enamel on steel.
inline constexpr double kJamCompliance = 1e-5;

/// Minimises 1/2 |x - t|^2 subject to a_i . x >= b_i: returns the point of a polyhedron nearest
/// to t.
/// Dual active set after Goldfarb & Idnani, Math. Programming 27 (1983) 1-33, with the identity
/// as Hessian (dual_active_set.inl).  It starts from t itself, so it needs no feasible start
/// (the limitation named at the end of chapter 2.3.3), and stops when no row is violated by more
/// than rounding.
///
/// Contradictory rows have no solution.  The problem is then solved again as
///   minimise 1/2 |x - t|^2 + eta^2 / (2 c)  subject to  a_i . x + eta >= b_i,  c = kJamCompliance,
///   by the same method with one more unknown.  A compliance on every row would work, too, but a
///   thousand copies of a row would then be a thousand active rows; here they are one.
///
/// @param t       6 x 1, target [unit of b].
/// @param rows    any number, all finite.  Duplicate, parallel and zero rows are allowed; a row
/// shorter than 1e-75 counts as a zero row.
/// @param guess,guesses  rows that were active last time, the most useful first; may repeat.
/// This is the plain C++ version; for many rows use Kernels::solve (server/physics/simd), which
/// uses the processor's widest vectors.
/// Real-time: no allocation, lock, log or clock.  Deterministic: equal inputs, equal bits.
QpResult SolveNearestPoint(const double* t, const QpRows& rows, const int* guess,
                           int guesses) noexcept;
/// SolveNearestPoint for two blocks of six unknowns, or up to four.
QpResultOf<12> SolveNearestPoint(const double* t, const QpRowsOf<12>& rows, const int* guess,
                                 int guesses) noexcept;
QpResultOf<24> SolveNearestPoint(const double* t, const QpRowsOf<24>& rows, const int* guess,
                                 int guesses) noexcept;

/// Rows that may be violated at a price: row i costs limit_i times what it lacks, so its multiplier
/// is at most limit_i.  Columns as in QpRows; `limit` is padded alike, and infinite where a row is
/// inviolable.  The solver writes to `a` and `b`: a row whose multiplier is at its limit is stored
/// with the opposite sign.
struct LimitedRows {
  double* a[6];
  double* b;
  const double* limit;  ///< >= 0 [unit of b]
  bool* at_limit;       ///< in: a guess; out: whether the multiplier is at its limit
  int count;
};

/// Minimises 1/2 |x - t|^2 + sum of limit_i max(0, b_i - a_i . x), by SolveNearestPoint's method.
/// A row at its limit pushes with a constant force; the limit less this force is the multiplier of
/// the opposite row -a_i . x >= -b_i, which has the same limit.  So any rows may begin at their
/// limits, and every iteration that adds a row raises the dual: no set of active rows and rows at
/// limits can return, and the method ends.
///
/// Contradictory rows are relaxed as above; only inviolable rows take part in the slack.
/// The result's multipliers are those of the rows as given.  Real-time, deterministic.
QpResult SolveLimited(const double* t, const LimitedRows& rows, const int* guess,
                      int guesses) noexcept;

}  // namespace palpate
