// The solver of nearest_point.h, compiled in plain C++ by nearest_point.cpp and for its instruction
// set by each server/physics/simd/kernels_*.cpp.  Every vector here is one of a multiple of eight
// doubles, used in the same order at every level.
#pragma once

#include "common/qp/nearest_point.h"
#include "common/qp/vector.h"

namespace palpate {
namespace {

/// Iterations; with limits, both of the problem and of the relaxed one.
constexpr int kIterationLimit = 400, kLimitedIterations = 2000;
/// A row counts as dependent if its part outside the span of the active rows is shorter than this,
/// relative to its length.
constexpr double kDependent = 1e-9;
/// A row shorter than this is ignored: its slack divided by its length squared must be finite.
constexpr double kShortestRow = 1e-75;
/// A projection that leaves less than this share of |a|^2 is repeated.
constexpr double kCancelled = 1e-2;
/// Ratio test: an r_j below this counts as rounding error.
constexpr double kRatioZero = 1e-13;
constexpr double kInfinity = __builtin_huge_val();
/// Square root of kJamCompliance = 1e-5 (nearest_point.h).
constexpr double kSlackEntry = 3.1622776601683795e-3;

/// Eight doubles in memory.
struct alignas(64) Lanes {
  double v[8];
  D8 Get() const { return Load(v); }
  void Set(D8 a) { Store(v, a); }
  double& operator[](int i) { return v[i]; }
  double operator[](int i) const { return v[i]; }
};

/// A Wide<W> in memory.
template <int W>
struct alignas(64) WideLanes {
  double v[8 * W];
  Wide<W> Get() const {
    Wide<W> a;
    for (int i = 0; i < W; ++i) a.part[i] = Load(v + 8 * i);
    return a;
  }
  void Set(const Wide<W>& a) {
    for (int i = 0; i < W; ++i) Store(v + 8 * i, a.part[i]);
  }
  double& operator[](int i) { return v[i]; }
  double operator[](int i) const { return v[i]; }
};

/// Goldfarb and Idnani's method on D = N unknowns, or N + 1 if a common slack relaxes the rows:
/// every row then has one more entry, sqrt(c), and x[N] is eta / sqrt(c).
///
/// The active rows, as columns A (D x k), are factored as A = Q S with Q orthonormal; only the
/// inverse M (k x k) of S is stored.  S need not be triangular, as theirs is: the method only needs
/// the multipliers of a direction, which are a product with M, and products are vectorised.
template <int N, bool kWithSlack, bool kLimited = false>
class DualActiveSet {
 public:
  DualActiveSet(const double* t, const QpRowsOf<N>& rows, const LimitedRows* limited = nullptr)
      : rows_(rows), limited_(limited) {
    double largest = 0.0;
    for (int i = 0; i < N; ++i) {
      t_[i] = t[i];
      const double size = t[i] < 0.0 ? -t[i] : t[i];
      if (size > largest) largest = size;
    }
    x_ = t_;
    tolerance_ = 1e-12 * (1.0 + largest);
    if constexpr (kLimited) {
      for (int i = 0; i < rows.count; ++i) {
        if (limited->at_limit[i]) TurnRound(i);
      }
      x_ = t_;
    }
  }

  /// Returns false if the rows contradict each other.
  bool Solve(const int* guess, int guesses, QpResultOf<N>& result) {
    if (kLimited) iterations_ = result.iterations;
    if (guesses > 0) Guess(guess, guesses);
    bool feasible = true;
    double slack = 0.0;
    int row = -1;
    while (NextViolated(row, slack)) {
      if (iterations_ >= kMostIterations) {
        result.status = QpStatus::kIterationLimit;
        break;
      }
      feasible = TakeUp(row, slack);
      if (!feasible) break;
    }
    if (feasible && active_ > 0) Polish();
    for (int i = 0; i < N; ++i) result.x[i] = x_[i];
    result.slack = kWithSlack ? kSlackEntry * x_[D - 1] : 0.0;
    result.active = active_;
    for (int j = 0; j < active_; ++j) {
      result.row[j] = row_[j];
      result.multiplier[j] = ForceOf(row_[j], u_[j] > 0.0 ? u_[j] : 0.0);
    }
    result.iterations = iterations_ + (kLimited ? 0 : result.iterations);
    return feasible;
  }

 private:
  static constexpr int D = N + (kWithSlack ? 1 : 0);
  static constexpr int W = (N + 8) / 8;  // with room for the slack in either case
  using Vector = Wide<W>;
  using Stored = WideLanes<W>;
  static constexpr int kMostIterations = kLimited ? kLimitedIterations : kIterationLimit;

  double LimitOf(int i) const {
    if constexpr (kLimited) return limited_->limit[i];
    return kInfinity;
  }

  /// Returns a row's entry for the slack: a row with a limit needs none.
  double SlackEntryOf(int i) const { return LimitOf(i) < kInfinity ? 0.0 : kSlackEntry; }
  /// Returns what the slack adds to eight rows, if it adds `shift` to each that takes part in it.
  D8 ShiftOf(int i, D8 shift) const {
    if constexpr (!kLimited) return shift;
    return SelectLess(Load(limited_->limit + i), Set1(kInfinity), Set1(0.0), shift);
  }

  /// Returns the multiplier of a row as given.
  double ForceOf(int i, double multiplier) const {
    if constexpr (!kLimited) return multiplier;
    if (!limited_->at_limit[i]) return multiplier;
    return multiplier < LimitOf(i) ? LimitOf(i) - multiplier : 0.0;
  }

  /// Replaces a row, whose multiplier has come to its limit, by the opposite one, whose multiplier
  /// is zero: the limit's force moves to t.  The columns hold the rows in that sense.
  void TurnRound(int i) {
    for (int c = 0; c < N; ++c) {
      t_[c] += limited_->limit[i] * limited_->a[c][i];
      limited_->a[c][i] = -limited_->a[c][i];
    }
    limited_->b[i] = -limited_->b[i];
  }
  void ComeToLimit(int i) {
    if constexpr (kLimited) {
      TurnRound(i);
      limited_->at_limit[i] = !limited_->at_limit[i];
    }
  }

  void LoadRow(int i, Stored& a) const {
    for (int c = 0; c < N; ++c) a[c] = rows_.a[c][i];
    if constexpr (kWithSlack) a[N] = SlackEntryOf(i);
  }

  double SlackOf(int i) const {
    double s = -rows_.b[i];
    for (int c = 0; c < N; ++c) s += rows_.a[c][i] * x_[c];
    if constexpr (kWithSlack) s += SlackEntryOf(i) * x_[N];
    return s;
  }

  /// Step 1: finds a strongly violated row.  A pass over all rows gives sixteen candidates, one per
  /// lane, which are used before the next pass, since the method may take any violated row.
  bool NextViolated(int& row, double& slack) {
    if (candidates_.lanes != 0 && FromCandidates(row, slack)) return true;
    Scan();
    return candidates_.lanes != 0 && FromCandidates(row, slack);
  }

  /// Finds the most violated row of each of sixteen lanes, the first of equals.
  void Scan() {
    D8 xs[N];
    for (int c = 0; c < N; ++c) xs[c] = Set1(x_[c]);
    const D8 shift = Set1(kWithSlack ? kSlackEntry * x_[D - 1] : 0.0);
    const auto slack = [&](int i) {
      D8 s = ShiftOf(i, shift) - Load(rows_.b + i);
      for (int c = 0; c < N; ++c) s = Fma(Load(rows_.a[c] + i), xs[c], s);
      return s;
    };
    D8 row = Set1(0.0), best0 = Set1(-tolerance_), best1 = best0;
    D8 best_row0 = Set1(-1.0), best_row1 = best_row0;
    const D8 sixteen = Set1(16.0);
    for (int i = 0; i < rows_.count; i += 16) {
      const D8 s0 = slack(i), s1 = slack(i + 8);
      best_row0 = SelectLess(s0, best0, row, best_row0);
      best0 = Min(s0, best0);
      best_row1 = SelectLess(s1, best1, row, best_row1);
      best1 = Min(s1, best1);
      row = row + sixteen;
    }
    const D8 none = Set1(-tolerance_);
    const std::uint32_t violated = Less(best0, none) | Less(best1, none) << 8;
    candidates_.lanes = violated;
    if (violated == 0) return;
    for (double* column : candidates_.a) ClearSixteen(column);
    ClearSixteen(candidates_.b);
    Lanes first[2];
    first[0].Set(best_row0);
    first[1].Set(best_row1);
    for (std::uint32_t left = violated; left != 0; left &= left - 1) {
      const int lane = __builtin_ctz(left);
      const int row_of_lane = static_cast<int>(first[lane >> 3][lane & 7]) + lane;
      candidates_.row[lane] = row_of_lane;
      for (int c = 0; c < N; ++c) candidates_.a[c][lane] = rows_.a[c][row_of_lane];
      candidates_.b[lane] = rows_.b[row_of_lane];
      if constexpr (kLimited) candidates_.limit[lane] = LimitOf(row_of_lane);
    }
    for (int half = 0; half < 2; ++half) {
      D8 aa = Set1(kWithSlack ? kSlackEntry * kSlackEntry : 1e-300);
      for (int c = 0; c < N; ++c) {
        const D8 a = Load(candidates_.a[c] + 8 * half);
        aa = Fma(a, a, aa);
      }
      Store(candidates_.inverse_norm + 8 * half, Set1(1.0) / Sqrt(aa));
    }
  }

  /// Returns the candidate whose half-space is farthest from x; discards those that hold by now.
  bool FromCandidates(int& row, double& slack) {
    const D8 shift = Set1(kWithSlack ? kSlackEntry * x_[D - 1] : 0.0);
    const D8 none = Set1(-tolerance_);
    Lanes value[2], distance[2];
    std::uint32_t violated = 0;
    for (int half = 0; half < 2; ++half) {
      D8 s = shift;
      if constexpr (kLimited) {
        s = SelectLess(Load(candidates_.limit + 8 * half), Set1(kInfinity), Set1(0.0), shift);
      }
      s = s - Load(candidates_.b + 8 * half);
      for (int c = 0; c < N; ++c) s = Fma(Load(candidates_.a[c] + 8 * half), Set1(x_[c]), s);
      value[half].Set(s);
      distance[half].Set(s * Load(candidates_.inverse_norm + 8 * half));
      violated |= Less(s, none) << (8 * half);
    }
    candidates_.lanes &= violated;
    if (candidates_.lanes == 0) return false;
    int worst = __builtin_ctz(candidates_.lanes);
    double farthest = distance[worst >> 3][worst & 7];
    for (std::uint32_t left = candidates_.lanes & (candidates_.lanes - 1); left != 0;
         left &= left - 1) {
      const int lane = __builtin_ctz(left);
      const double s = distance[lane >> 3][lane & 7];
      if (s < farthest) {
        farthest = s;
        worst = lane;
      }
    }
    slack = value[worst >> 3][worst & 7];
    row = candidates_.row[worst];
    candidates_.lanes &= ~(1u << worst);
    return true;
  }

  static void ClearSixteen(double* column) {
    Store(column, Set1(0.0));
    Store(column + 8, Set1(0.0));
  }

  static Vector Zero() { return SetAll<W>(0.0); }

  static double SumOfSquares(const Stored& a) {
    double even = a[0] * a[0], odd = a[1] * a[1];
    for (int c = 2; c < D; c += 2) even += a[c] * a[c];
    for (int c = 3; c < D; c += 2) odd += a[c] * a[c];
    return even + odd;
  }

  /// Returns the sum of weight[i] * vector[i] over i < n.  Even and odd i are added separately: two
  /// short chains of additions take half the time of one long chain.
  static Vector Combine(const Stored& weight, const Stored* vector, int n) {
    Vector even = Zero(), odd = even;
    int i = 0;
    for (; i + 1 < n; i += 2) {
      even = Fma(weight[i], vector[i].Get(), even);
      odd = Fma(weight[i + 1], vector[i + 1].Get(), odd);
    }
    if (i < n) even = Fma(weight[i], vector[i].Get(), even);
    return even + odd;
  }

  /// z := z - Q Q^T z, d := d + Q^T z.
  void ProjectOnce(Stored& d, Stored& z) const {
    const Vector dot = Combine(z, Q_rows_, D);
    Stored part;
    part.Set(dot);
    z.Set(z.Get() - Combine(part, Q_, active_));
    d.Set(d.Get() + dot);
  }

  /// d = Q^T a and z = a - Q d.  Orthogonalises a second time if the first cancelled much ("twice
  /// is enough", Giraud & Langou 2005).  Returns |z|^2; 0 if a lies in the span of the active rows,
  /// or is a zero row.
  double Project(const Stored& a, Stored& d, Stored& z) const {
    z = a;
    const double aa = SumOfSquares(a);
    if (!(aa > kShortestRow * kShortestRow)) return 0.0;
    if (active_ == 0) return aa;
    ProjectOnce(d, z);
    double zz = SumOfSquares(z);
    if (zz < kCancelled * aa) {
      ProjectOnce(d, z);
      zz = SumOfSquares(z);
    }
    return active_ < D && zz > kDependent * kDependent * aa ? zz : 0.0;
  }

  /// Returns M y.
  Vector Multipliers(const Stored& y) const { return Combine(y, M_, active_); }

  /// Adds a row: Q gains the column z / |z|, S the column (d, |z|), and so M the column (-M d, 1)
  /// / |z|.
  void Append(int row, const Stored& z, double zz, const Vector& r, double multiplier) {
    const double inverse = 1.0 / __builtin_sqrt(zz);
    Q_[active_].Set(inverse * z.Get());
    for (int c = 0; c < D; ++c) Q_rows_[c][active_] = Q_[active_][c];
    M_[active_].Set(-inverse * r);
    M_[active_][active_] = inverse;
    row_[active_] = row;
    u_[active_] = multiplier;
    ++active_;
  }

  /// Removes active row l.  Row l of M, w, is the direction within the span that is orthogonal to
  /// the other rows; a reflection turns it into the last basis vector, which is then removed.
  void Drop(int l) {
    const int last = active_ - 1;
    Stored v{};
    double ww = 0.0;
    for (int j = 0; j <= last; ++j) {
      v[j] = M_[j][l];
      ww += v[j] * v[j];
    }
    const double length = __builtin_sqrt(ww);
    v[last] += v[last] < 0.0 ? -length : length;
    double vv = 0.0;
    for (int j = 0; j <= last; ++j) vv += v[j] * v[j];
    const double beta = 2.0 / vv;
    Vector Mv = Zero(), Qv = Mv;
    for (int j = 0; j <= last; ++j) {
      Mv = Fma(v[j], M_[j].Get(), Mv);
      Qv = Fma(v[j], Q_[j].Get(), Qv);
    }
    for (int j = 0; j < last; ++j) {
      const double scale = beta * v[j];
      M_[j].Set(Fnma(scale, Mv, M_[j].Get()));
      Q_[j].Set(Fnma(scale, Qv, Q_[j].Get()));
      for (int i = l; i < last; ++i) M_[j][i] = M_[j][i + 1];
      M_[j][last] = 0.0;
      for (int c = 0; c < D; ++c) Q_rows_[c][j] = Q_[j][c];
    }
    for (int c = 0; c < D; ++c) Q_rows_[c][last] = 0.0;
    for (int j = l; j < last; ++j) {
      row_[j] = row_[j + 1];
      u_[j] = u_[j + 1];
    }
    u_[last] = 0.0;
    active_ = last;
  }

  /// Step 2: moves x until the row holds with equality or its multiplier reaches its limit, and
  /// drops active rows whose multiplier reaches zero or its limit on the way.  Returns false if the
  /// row cannot be made to hold.
  bool TakeUp(int row, double slack) {
    if constexpr (kLimited) {
      // Only rounding makes an active row seem violated.
      for (int j = 0; j < active_; ++j) {
        if (row_[j] != row) continue;
        ++iterations_;
        Equalise();
        return true;
      }
      slack = SlackOf(row);  // it may have come to its limit since it was found
      if (!(slack < -tolerance_)) return true;
    }
    Stored a{};
    LoadRow(row, a);
    double multiplier = 0.0;
    for (;;) {
      ++iterations_;
      Stored d{}, z, r;
      const double zz = Project(a, d, z);
      const Vector Md = Multipliers(d);
      r.Set(Md);
      // Least u_j / r_j, compared without dividing.
      int leaving = -1;
      for (int j = 0; j < active_; ++j) {
        if (r[j] > kRatioZero && (leaving < 0 || u_[j] * r[leaving] < u_[leaving] * r[j])) {
          leaving = j;
        }
      }
      double dual_step = leaving < 0 ? kInfinity : u_[leaving] / r[leaving];
      bool to_limit = false;
      if constexpr (kLimited) {
        if (LimitOf(row) - multiplier < dual_step) {
          dual_step = LimitOf(row) - multiplier;
          leaving = active_;  // the row itself
          to_limit = true;
        }
        for (int j = 0; j < active_; ++j) {
          if (!(r[j] < -kRatioZero && LimitOf(row_[j]) - u_[j] < -r[j] * dual_step)) continue;
          dual_step = (LimitOf(row_[j]) - u_[j]) / -r[j];
          leaving = j;
          to_limit = true;
        }
      }
      const bool reachable = zz > 0.0;
      if (!reachable && leaving < 0) return false;
      const double full_step = reachable ? -slack / zz : kInfinity;
      const double step = full_step < dual_step ? full_step : dual_step;
      u_.Set(Fnma(step, Md, u_.Get()));
      multiplier += step;
      if (reachable) {
        x_.Set(Fma(step, z.Get(), x_.Get()));
        slack += step * zz;
      }
      if (full_step <= dual_step) {
        Append(row, z, zz, Md, multiplier);
        return true;
      }
      if constexpr (kLimited) {
        if (to_limit) ComeToLimit(leaving == active_ ? row : row_[leaving]);
        if (leaving == active_) return true;
      }
      Drop(leaving);
      if (iterations_ >= kMostIterations) return true;  // the caller stops at the limit
    }
  }

  /// Corrects x and u so that the active rows hold with equality:
  /// A^T x = b means Q^T dx = M^T (b - A^T x), and du = M Q^T dx.
  void Equalise() {
    Stored residual, y;
    for (int j = 0; j < active_; ++j) residual[j] = -SlackOf(row_[j]);
    for (int j = 0; j < active_; ++j) {
      double dot = 0.0;
      for (int i = 0; i < active_; ++i) dot += M_[j][i] * residual[i];
      y[j] = dot;
    }
    x_.Set(x_.Get() + Combine(y, Q_, active_));
    u_.Set(u_.Get() + Multipliers(y));
  }

  /// Returns how far an active multiplier is inside its limits.
  double RoomOf(int j) const {
    if constexpr (!kLimited) return u_[j];
    const double left = LimitOf(row_[j]) - u_[j];
    return left < u_[j] ? left : u_[j];
  }

  /// Starts from last time's active rows: any subset with non-negative multipliers is as valid a
  /// start as the empty one.
  void Guess(const int* guess, int guesses) {
    for (int i = 0; i < guesses && active_ < D; ++i) {
      Stored a{}, d{}, z;
      LoadRow(guess[i], a);
      const double zz = Project(a, d, z);
      if (zz > 0.0) Append(guess[i], z, zz, Multipliers(d), 0.0);
    }
    while (active_ > 0) {
      x_ = t_;
      u_ = Stored();
      Equalise();
      int worst = 0;
      for (int j = 1; j < active_; ++j) {
        if (RoomOf(j) < RoomOf(worst)) worst = j;
      }
      if (RoomOf(worst) >= 0.0) return;
      ++iterations_;
      if constexpr (kLimited) {
        if (u_[worst] > 0.0) ComeToLimit(row_[worst]);
      }
      Drop(worst);
    }
    x_ = t_;
  }

  /// Removes the rounding errors accumulated by the steps: recomputes the multipliers from the
  /// gradient, then corrects the remaining residuals of the active rows.
  void Polish() {
    Stored y;
    Stored moved;
    moved.Set(x_.Get() - t_.Get());
    y.Set(Combine(moved, Q_rows_, D));
    u_.Set(Multipliers(y));
    x_.Set(t_.Get() + Combine(y, Q_, active_));
    Equalise();
  }

  const QpRowsOf<N>& rows_;
  const LimitedRows* limited_;  ///< the same rows, with limits; null if there are none
  Stored t_{}, x_, u_{};
  Stored Q_[N + 1];         ///< Q_[j]: j-th basis vector
  Stored Q_rows_[N + 1]{};  ///< the transpose: lane j of Q_rows_[c] is Q_[j][c]
  Stored M_[N + 1];         ///< M_[j]: j-th column of S^-1
  int row_[N + 1];
  int active_ = 0;
  int iterations_ = 0;
  /// Violated rows, one of each lane.
  struct {
    std::uint32_t lanes = 0;  ///< one bit for each
    int row[16];
    alignas(64) double a[N][16];
    alignas(64) double b[16];
    alignas(64) double limit[kLimited ? 16 : 1];
    alignas(64) double inverse_norm[16];
  } candidates_;
  double tolerance_;
};

template <int N>
QpResultOf<N> Solve(const double* t, const QpRowsOf<N>& rows, const int* guess, int guesses) {
  QpResultOf<N> result;
  if (rows.count == 0) {
    for (int i = 0; i < N; ++i) result.x[i] = t[i];
    return result;
  }
  if (DualActiveSet<N, false>(t, rows).Solve(guess, guesses, result)) return result;
  result.status = QpStatus::kRelaxed;
  if (!DualActiveSet<N, true>(t, rows).Solve(nullptr, 0, result)) {
    result.status = QpStatus::kIterationLimit;  // cannot happen: a slack satisfies any rows
  }
  return result;
}

template <int N>
QpResult SolveWithLimits(const double* t, const LimitedRows& limited, const int* guess,
                         int guesses) {
  QpRows rows{{}, limited.b, limited.count};
  for (int c = 0; c < N; ++c) rows.a[c] = limited.a[c];
  QpResult result;
  if (DualActiveSet<N, false, true>(t, rows, &limited).Solve(guess, guesses, result)) return result;
  // What has come to its limit is a guess for the relaxed problem.
  for (int i = 0; i < limited.count; ++i) {
    if (!limited.at_limit[i]) continue;
    for (int c = 0; c < N; ++c) limited.a[c][i] = -limited.a[c][i];
    limited.b[i] = -limited.b[i];
  }
  result.status = QpStatus::kRelaxed;
  if (!DualActiveSet<N, true, true>(t, rows, &limited).Solve(nullptr, 0, result)) {
    result.status = QpStatus::kIterationLimit;  // cannot happen: a slack satisfies any rows
  }
  return result;
}

}  // namespace
}  // namespace palpate
