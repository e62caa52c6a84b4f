#include "common/qp/nearest_point.h"

#include "common/qp/dual_active_set.inl"

namespace palpate {

QpResult SolveNearestPoint(const double* t, const QpRows& rows, const int* guess,
                           int guesses) noexcept {
  return Solve<6>(t, rows, guess, guesses);
}

QpResultOf<12> SolveNearestPoint(const double* t, const QpRowsOf<12>& rows, const int* guess,
                                 int guesses) noexcept {
  return Solve<12>(t, rows, guess, guesses);
}

QpResultOf<24> SolveNearestPoint(const double* t, const QpRowsOf<24>& rows, const int* guess,
                                 int guesses) noexcept {
  return Solve<24>(t, rows, guess, guesses);
}

QpResult SolveLimited(const double* t, const LimitedRows& rows, const int* guess,
                      int guesses) noexcept {
  return SolveWithLimits<6>(t, rows, guess, guesses);
}

}  // namespace palpate
