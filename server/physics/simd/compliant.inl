// The solver of SolveCompliant (solve/qp_solver.h), one of the loops that each kernels_*.cpp
// compiles for its instruction set.
#include "common/qp/dual_active_set.inl"
#include "common/qp/vector.h"
#include "server/physics/limits.h"
#include "server/physics/simd/kernels.h"

namespace palpate {
namespace {

using namespace limits::compliance;

constexpr double kRelaxedCompliance = kSlackEntry * kSlackEntry;

inline double SumOfLanes(D8 a) {
  Lanes lanes;
  lanes.Set(a);
  return ((lanes[0] + lanes[1]) + (lanes[2] + lanes[3])) +
         ((lanes[4] + lanes[5]) + (lanes[6] + lanes[7]));
}

/// Semismooth Newton (Qi & Sun, Math. Programming 58 (1993) 353-367) on
///   f(x) = 1/2 |x - t|^2 + sum_i w_i / 2 max(0, b_i - a_i . x)^2
/// over the polyhedron of the rigid rows.  With the soft rows that overlap at x as they are, f is a
/// quadratic with Hessian H = I + sum w a a^T = L L^T; in y = L^T x its least point is a nearest
/// point again, under the rows L^-1 a.  Where the same rows overlap there, that is the solution.
/// f is convex: where a step overshoots, a search along it ends in less (Pang & Qi, J. Optim.
/// Theory Appl. 85 (1995) 633-648), so that no cycle is possible.
template <int N>
class CompliantSolver {
 public:
  CompliantSolver(const double* t, const CompliantRows& rows) : rows_(rows) {
    double largest = 0.0;
    for (int i = 0; i < N; ++i) {
      t_[i] = t[i];
      const double size = t[i] < 0.0 ? -t[i] : t[i];
      if (size > largest) largest = size;
    }
    tolerance_ = 1e-12 * (1.0 + largest);
  }

  QpResult Solve(const int* guess, int guesses) {
    for (int i = 0; i < 6; ++i) rows_.pull[i] = 0.0;
    *rows_.pushing = 0;
    QpResult result;
    // From where the tool is: what overlaps there mostly does so after the step too.
    Point now;
    Evaluate<false>(now);
    Evaluate<true>(now);
    int warm[kMaxActiveRows];
    for (int i = 0; i < guesses; ++i) warm[i] = guess[i];
    int iterations = 0;
    for (int turn = 0; turn < kNewtonLimit; ++turn) {
      ++iterations;
      double q[N];
      Factorise(now, q);
      result = Minimise(q, warm, guesses);
      iterations += result.iterations;
      result.iterations = iterations;
      if (result.status == QpStatus::kIterationLimit) return result;
      Point next;
      for (int i = 0; i < N; ++i) next.x[i] = result.x[i];
      next.slack = result.slack;
      Evaluate<false>(next);
      if (SameRows(now, next, q)) {
        for (int i = 0; i < N; ++i) rows_.pull[i] = next.pull[i];
        *rows_.pushing = next.pushing;
        return result;
      }
      // The first step also leads into the polyhedron, where a step may not be cut short.
      if (turn > 0 && !Gains(now, next)) Search(now, next);
      now = next;
      Evaluate<true>(now);
      guesses = result.active;
      for (int i = 0; i < guesses; ++i) warm[i] = result.row[i];
    }
    result.status = QpStatus::kIterationLimit;
    return result;
  }

 private:
  static constexpr int kEntries = N * (N + 1) / 2;

  /// A point, and what the soft rows that overlap there add.
  struct Point {
    double x[N] = {};
    double slack = 0.0;
    double H[kEntries];  ///< lower triangle of sum w a a^T, row by row
    double pull[N];      ///< sum w s a, s the overlap
    double value;        ///< f
    int pushing;         ///< how many overlap
  };

  /// Everything but the Hessian, which only the next quadratic needs; or the Hessian alone.
  template <bool kHessian>
  void Evaluate(Point& point) const {
    const QpRows& rigid = rows_.rigid;
    constexpr int kSums = kHessian ? kEntries : N;
    D8 xs[N], sum[kSums];
    for (int c = 0; c < N; ++c) xs[c] = Set1(point.x[c]);
    const D8 zero = Set1(0.0);
    for (D8& entry : sum) entry = zero;
    D8 energy = zero;
    int pushing = 0;
    for (int i = 0; i < rigid.count; i += 8) {
      D8 a[N];
      D8 s = Load(rows_.soft_b + i);
      for (int c = 0; c < N; ++c) {
        a[c] = Load(rigid.a[c] + i);
        s = Fnma(a[c], xs[c], s);
      }
      const D8 w = SelectLess(zero, s, Load(rows_.weight + i), zero);
      const std::uint32_t overlap = Less(zero, w);
      if constexpr (kHessian) {
        if (overlap == 0) continue;
        for (int r = 0, k = 0; r < N; ++r) {
          const D8 wa = w * a[r];
          for (int c = 0; c <= r; ++c, ++k) sum[k] = Fma(wa, a[c], sum[k]);
        }
      } else {
        const D8 ws = w * s;
        Store(rows_.push + i, ws);
        if (overlap == 0) continue;
        pushing += __builtin_popcount(overlap);
        energy = Fma(ws, s, energy);
        for (int r = 0; r < N; ++r) sum[r] = Fma(ws, a[r], sum[r]);
      }
    }
    if constexpr (kHessian) {
      for (int k = 0; k < kEntries; ++k) point.H[k] = SumOfLanes(sum[k]);
    } else {
      double distance = 0.0;
      for (int r = 0; r < N; ++r) {
        point.pull[r] = SumOfLanes(sum[r]);
        distance += (point.x[r] - t_[r]) * (point.x[r] - t_[r]);
      }
      point.value =
          0.5 * (distance + SumOfLanes(energy) + point.slack * point.slack / kRelaxedCompliance);
      point.pushing = pushing;
    }
  }

  static double Entry(const double* lower, int r, int c) {
    return r >= c ? lower[r * (r + 1) / 2 + c] : lower[c * (c + 1) / 2 + r];
  }

  /// (I + sum w a a^T) x, row r.
  static double HessianTimes(const Point& point, const double* x, int r) {
    double sum = x[r];
    for (int c = 0; c < N; ++c) sum += Entry(point.H, r, c) * x[c];
    return sum;
  }

  /// The quadratic at a point, 1/2 x . H x - q . x, and H = L L^T.
  void Factorise(const Point& point, double* q) {
    for (int r = 0; r < N; ++r) {
      q[r] = HessianTimes(point, point.x, r) - point.x[r] + t_[r] + point.pull[r];
    }
    for (int r = 0; r < N; ++r) {
      for (int c = 0; c <= r; ++c) {
        double sum = Entry(point.H, r, c) + (r == c ? 1.0 : 0.0);
        for (int k = 0; k < c; ++k) sum -= L_[r][k] * L_[c][k];
        if (r == c) {
          L_[r][r] = __builtin_sqrt(sum);
          inverse_diagonal_[r] = 1.0 / L_[r][r];
        } else {
          L_[r][c] = sum * inverse_diagonal_[c];
        }
      }
    }
  }

  /// Least point of that quadratic under the rigid rows.
  QpResult Minimise(const double* q, const int* guess, int guesses) const {
    double y[N];
    for (int r = 0; r < N; ++r) {
      double sum = q[r];
      for (int c = 0; c < r; ++c) sum -= L_[r][c] * y[c];
      y[r] = sum * inverse_diagonal_[r];
    }
    QpResult result;
    Back(y, result.x);
    if (RigidHold(result.x)) return result;
    QpRows transformed = Transform();
    result = palpate::Solve<N>(y, transformed, guess, guesses);
    for (int r = 0; r < N; ++r) y[r] = result.x[r];
    Back(y, result.x);
    return result;
  }

  /// x = L^-T y.
  void Back(const double* y, double* x) const {
    for (int r = N - 1; r >= 0; --r) {
      double sum = y[r];
      for (int c = r + 1; c < N; ++c) sum -= L_[c][r] * x[c];
      x[r] = sum * inverse_diagonal_[r];
    }
  }

  bool RigidHold(const double* x) const {
    const QpRows& rigid = rows_.rigid;
    const D8 none = Set1(-tolerance_);
    D8 xs[N];
    for (int c = 0; c < N; ++c) xs[c] = Set1(x[c]);
    D8 least = Set1(0.0);
    for (int i = 0; i < rigid.count; i += 8) {
      D8 s = Set1(0.0) - Load(rigid.b + i);
      for (int c = 0; c < N; ++c) s = Fma(Load(rigid.a[c] + i), xs[c], s);
      least = Min(s, least);
    }
    return Less(least, none) == 0;
  }

  /// The rigid rows in y: L^-1 a, by forward substitution, to the end of their padding.
  QpRows Transform() const {
    const QpRows& rigid = rows_.rigid;
    QpRows out = rigid;
    for (int c = 0; c < N; ++c) out.a[c] = rows_.transformed[c];
    for (int i = 0; i < rigid.count; i += 16) {
      for (int half = i; half < i + 16; half += 8) {
        D8 a[N];
        for (int r = 0; r < N; ++r) {
          D8 sum = Load(rigid.a[r] + half);
          for (int c = 0; c < r; ++c) sum = Fnma(Set1(L_[r][c]), a[c], sum);
          a[r] = sum * Set1(inverse_diagonal_[r]);
          Store(rows_.transformed[r] + half, a[r]);
        }
      }
    }
    return out;
  }

  /// True where the gradient of f at `next` is that of the quadratic which led there.
  bool SameRows(const Point& now, const Point& next, const double* q) const {
    double stiffness = 1.0, size = 0.0, largest = 0.0;
    for (int r = 0; r < N; ++r) {
      stiffness += Entry(now.H, r, r);
      size += q[r] < 0.0 ? -q[r] : q[r];
      const double x = next.x[r] < 0.0 ? -next.x[r] : next.x[r];
      if (x > largest) largest = x;
    }
    // What the terms' rounding adds up to, where they nearly cancel.
    const double rounding = tolerance_ + kRounding * (size + stiffness * largest);
    for (int r = 0; r < N; ++r) {
      const double f = next.x[r] - t_[r] - next.pull[r];
      const double difference = f - (HessianTimes(now, next.x, r) - q[r]);
      if (difference > rounding || difference < -rounding) return false;
    }
    return true;
  }

  /// Slope of f at `at`, towards `to` from `from`.
  double Slope(const Point& at, const Point& from, const Point& to) const {
    double slope = at.slack * (to.slack - from.slack) / kRelaxedCompliance;
    for (int r = 0; r < N; ++r) {
      slope += (at.x[r] - t_[r] - at.pull[r]) * (to.x[r] - from.x[r]);
    }
    return slope;
  }

  bool Gains(const Point& now, const Point& next) const {
    return next.value <= now.value + kLeastGain * Slope(now, now, next) ||
           Slope(next, now, next) <= 0.0;
  }

  /// Puts `next` where f falls no longer on the way from `now`: by halving, the slope being
  /// monotone.
  void Search(const Point& now, Point& next) const {
    const Point end = next;
    const double enough = kSlopeLeft * Slope(now, now, end);
    double low = 0.0, high = 1.0;
    for (int i = 0; i < kLineSearchLimit; ++i) {
      const double part = 0.5 * (low + high);
      for (int r = 0; r < N; ++r) next.x[r] = now.x[r] + part * (end.x[r] - now.x[r]);
      next.slack = now.slack + part * (end.slack - now.slack);
      Evaluate<false>(next);
      const double slope = Slope(next, now, end);
      if (slope <= 0.0 && slope >= enough) return;
      (slope > 0.0 ? high : low) = part;
    }
  }

  const CompliantRows& rows_;
  double t_[N];
  double L_[N][N];
  double inverse_diagonal_[N];
  double tolerance_;
};

template <int N>
QpResult SolveCompliantRows(const double* t, const CompliantRows& rows, const int* guess,
                            int guesses) {
  return CompliantSolver<N>(t, rows).Solve(guess, guesses);
}

}  // namespace
}  // namespace palpate
