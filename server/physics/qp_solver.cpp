#include "server/physics/qp_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate {
namespace {

constexpr int kIterationLimit = 400;
/// A row whose part outside the span of the active ones is shorter than this lies inside it.
constexpr double kDependent = 1e-9;
/// Ratio test: an r_j below this is rounding.
constexpr double kRatioZero = 1e-13;

/// The method on D = N unknowns, or N + 1 where a common slack relaxes the rows: then every row has
/// one more entry, sqrt(c), and x[N] is eta / sqrt(c).
template <int N, bool kWithSlack>
class DualActiveSet {
 public:
  DualActiveSet(const Kernels& kernels, const double* t, const QpRows& rows)
      : kernels_(kernels), rows_(rows) {
    double largest = 0.0;
    for (int i = 0; i < N; ++i) {
      t_[i] = t[i];
      largest = std::max(largest, std::abs(t[i]));
    }
    if constexpr (kWithSlack) t_[N] = 0.0;
    std::copy(t_, t_ + D, x_);
    tolerance_ = 1e-12 * (1.0 + largest);
  }

  /// False where the rows contradict each other.
  bool Solve(const int* guess, int guesses, QpResult& result) {
    if (guesses > 0) Guess(guess, guesses);
    bool feasible = true;
    int row = -1;
    double slack = 0.0;
    while (NextViolated(row, slack)) {
      if (iterations_ >= kIterationLimit) {
        result.status = QpStatus::kIterationLimit;
        break;
      }
      feasible = TakeUp(row, slack);
      if (!feasible) break;
    }
    if (feasible) Polish();
    std::copy(x_, x_ + N, result.x);
    result.slack = kWithSlack ? kSlackEntry * x_[D - 1] : 0.0;
    result.active = active_;
    std::copy(row_, row_ + active_, result.row);
    for (int j = 0; j < active_; ++j) result.multiplier[j] = std::max(0.0, u_[j]);
    result.iterations += iterations_;
    return feasible;
  }

 private:
  static constexpr int D = N + (kWithSlack ? 1 : 0);
  static inline const double kSlackEntry = std::sqrt(kJamCompliance);

  void LoadRow(int i, double* a) const {
    for (int c = 0; c < N; ++c) a[c] = rows_.a[c][i];
    if constexpr (kWithSlack) a[N] = kSlackEntry;
  }

  double SlackOf(int i) const {
    double s = -rows_.b[i];
    for (int c = 0; c < N; ++c) s += rows_.a[c][i] * x_[c];
    if constexpr (kWithSlack) s += kSlackEntry * x_[N];
    return s;
  }

  /// Step 1: the most violated row.  A pass over all rows leaves sixteen candidates, one per lane;
  /// those are used up before the next pass, for any violated row will do.
  bool NextViolated(int& row, double& slack) {
    if (candidates_ > 0 && FromCandidates(row, slack)) return true;
    if (rows_.count == 0) return false;
    ScanResult scan;
    const int padded = (rows_.count + 15) & ~15;
    if constexpr (N == 6) {
      kernels_.scan_rows_6(rows_.a, rows_.b, padded, x_, scan);
    } else {
      kernels_.scan_rows_3(rows_.a, rows_.b, padded, x_, scan);
    }
    const double shift = kWithSlack ? kSlackEntry * x_[D - 1] : 0.0;
    candidates_ = 0;
    int worst = -1;
    double least = -tolerance_;
    for (int lane = 0; lane < 16; ++lane) {
      const double value = scan.value[lane] + shift;
      if (value >= -tolerance_) continue;
      candidate_[candidates_] = static_cast<int>(scan.row[lane]);
      if (value < least) {
        least = value;
        worst = candidates_;
      }
      ++candidates_;
    }
    if (worst < 0) return false;
    row = candidate_[worst];
    candidate_[worst] = candidate_[--candidates_];
    slack = SlackOf(row);
    return slack < 0.0;
  }

  bool FromCandidates(int& row, double& slack) {
    int worst = -1;
    double least = -tolerance_;
    int kept = 0;
    for (int i = 0; i < candidates_; ++i) {
      const double s = SlackOf(candidate_[i]);
      if (s >= -tolerance_) continue;  // satisfied on the way
      candidate_[kept] = candidate_[i];
      if (s < least) {
        least = s;
        worst = kept;
      }
      ++kept;
    }
    candidates_ = kept;
    if (worst < 0) return false;
    row = candidate_[worst];
    slack = least;
    candidate_[worst] = candidate_[--candidates_];
    return true;
  }

  /// d = Q^T a and z = a - Q d, orthogonalised twice ("twice is enough", Giraud & Langou 2005).
  /// Returns |z|^2, 0 where a lies in the span of the active rows.
  double Project(const double* a, double* d, double* z) const {
    std::copy(a, a + D, z);
    std::fill(d, d + D, 0.0);
    double aa = 0.0;
    for (int c = 0; c < D; ++c) aa += a[c] * a[c];
    if (active_ == 0) return aa;
    if (active_ == D) return 0.0 * ProjectOnce(d, z);
    ProjectOnce(d, z);
    const double zz = ProjectOnce(d, z);
    return zz > kDependent * kDependent * aa ? zz : 0.0;
  }

  double ProjectOnce(double* d, double* z) const {
    for (int j = 0; j < active_; ++j) {
      double dot = 0.0;
      for (int c = 0; c < D; ++c) dot += q_[j][c] * z[c];
      d[j] += dot;
      for (int c = 0; c < D; ++c) z[c] -= dot * q_[j][c];
    }
    double zz = 0.0;
    for (int c = 0; c < D; ++c) zz += z[c] * z[c];
    return zz;
  }

  /// r = R^-1 d.
  void SolveTriangle(const double* d, double* r) const {
    for (int i = active_ - 1; i >= 0; --i) {
      double s = d[i];
      for (int j = i + 1; j < active_; ++j) s -= r_[j][i] * r[j];
      r[i] = s / r_[i][i];
    }
  }

  void Append(int row, const double* d, const double* z, double zz, double multiplier) {
    const double length = std::sqrt(zz);
    const double inverse = 1.0 / length;
    for (int c = 0; c < D; ++c) q_[active_][c] = z[c] * inverse;
    std::copy(d, d + active_, r_[active_]);
    r_[active_][active_] = length;
    row_[active_] = row;
    u_[active_] = multiplier;
    ++active_;
  }

  /// Takes column l out of the factors; plane rotations make R a triangle again.
  void Drop(int l) {
    --active_;
    for (int j = l; j < active_; ++j) {
      std::copy(r_[j + 1], r_[j + 1] + j + 2, r_[j]);
      row_[j] = row_[j + 1];
      u_[j] = u_[j + 1];
    }
    for (int j = l; j < active_; ++j) {
      const double f = r_[j][j], g = r_[j][j + 1];
      const double h = std::sqrt(f * f + g * g);
      const double cosine = f / h, sine = g / h;
      r_[j][j] = h;
      for (int k = j + 1; k < active_; ++k) {
        const double upper = r_[k][j], lower = r_[k][j + 1];
        r_[k][j] = cosine * upper + sine * lower;
        r_[k][j + 1] = cosine * lower - sine * upper;
      }
      for (int c = 0; c < D; ++c) {
        const double left = q_[j][c], right = q_[j + 1][c];
        q_[j][c] = cosine * left + sine * right;
        q_[j + 1][c] = cosine * right - sine * left;
      }
    }
  }

  /// Step 2: moves until the row holds with equality, dropping active rows whose multiplier comes
  /// to zero on the way.  False where it cannot be made to hold.
  bool TakeUp(int row, double slack) {
    double a[D], d[D], z[D], r[D];
    LoadRow(row, a);
    double multiplier = 0.0;
    for (;;) {
      ++iterations_;
      const double zz = Project(a, d, z);
      SolveTriangle(d, r);
      double dual_step = std::numeric_limits<double>::infinity();
      int leaving = -1;
      for (int j = 0; j < active_; ++j) {
        if (r[j] > kRatioZero && u_[j] < dual_step * r[j]) {
          dual_step = u_[j] / r[j];
          leaving = j;
        }
      }
      const bool reachable = zz > 0.0;
      if (!reachable && leaving < 0) return false;
      const double full_step = reachable ? -slack / zz : std::numeric_limits<double>::infinity();
      const double step = std::min(full_step, dual_step);
      for (int j = 0; j < active_; ++j) u_[j] -= step * r[j];
      multiplier += step;
      if (reachable) {
        for (int c = 0; c < D; ++c) x_[c] += step * z[c];
        slack += step * zz;
      }
      if (full_step <= dual_step) {
        Append(row, d, z, zz, multiplier);
        return true;
      }
      Drop(leaving);
      if (iterations_ >= kIterationLimit) return true;  // the caller stops at the limit
    }
  }

  /// Multipliers and point of the active rows held as equalities: x = t + Q y, R u = y.
  void Equalities() {
    double y[D];
    for (int i = 0; i < active_; ++i) {
      double s = rows_.b[row_[i]];
      for (int j = 0; j < i; ++j) s -= r_[i][j] * y[j];
      y[i] = s / r_[i][i];
    }
    std::copy(t_, t_ + D, x_);
    for (int i = 0; i < active_; ++i) {
      double dot = 0.0;
      for (int c = 0; c < D; ++c) dot += q_[i][c] * t_[c];
      // y[i] is R^-T b; what Q^T t does not yet give of it is the step.
      u_[i] = y[i] - dot;
      for (int c = 0; c < D; ++c) x_[c] += u_[i] * q_[i][c];
    }
    double step[D];
    std::copy(u_, u_ + active_, step);
    SolveTriangle(step, u_);
  }

  /// Start from last time's active rows: any subset whose multipliers are not negative is as good a
  /// start as the empty one.
  void Guess(const int* guess, int guesses) {
    double a[D], d[D], z[D];
    for (int i = 0; i < guesses && active_ < D; ++i) {
      LoadRow(guess[i], a);
      const double zz = Project(a, d, z);
      if (zz > 0.0) Append(guess[i], d, z, zz, 0.0);
    }
    while (active_ > 0) {
      Equalities();
      const int worst = static_cast<int>(std::min_element(u_, u_ + active_) - u_);
      if (u_[worst] >= 0.0) return;
      ++iterations_;
      Drop(worst);
    }
    std::copy(t_, t_ + D, x_);
  }

  /// Removes the rounding that the steps have gathered.
  void Polish() {
    if (active_ > 0) Equalities();
  }

  const Kernels& kernels_;
  const QpRows& rows_;
  double t_[D];
  alignas(64) double x_[D];
  double q_[D][D];  ///< q_[j]: j-th basis vector
  double r_[D][D];  ///< r_[j]: j-th column of R
  double u_[D];
  int row_[D];
  int active_ = 0;
  int iterations_ = 0;
  int candidate_[16];
  int candidates_ = 0;
  double tolerance_;
};

}  // namespace

template <int N>
QpResult SolveNearestPoint(const Kernels& kernels, const double* t, const QpRows& rows,
                           const int* guess, int guesses) noexcept {
  QpResult result;
  if (DualActiveSet<N, false>(kernels, t, rows).Solve(guess, guesses, result)) return result;
  result.status = QpStatus::kRelaxed;
  if (!DualActiveSet<N, true>(kernels, t, rows).Solve(nullptr, 0, result)) {
    result.status = QpStatus::kIterationLimit;  // cannot be: a slack satisfies any rows
  }
  return result;
}

template QpResult SolveNearestPoint<3>(const Kernels&, const double*, const QpRows&, const int*,
                                       int) noexcept;
template QpResult SolveNearestPoint<6>(const Kernels&, const double*, const QpRows&, const int*,
                                       int) noexcept;

}  // namespace palpate
