#include "server/physics/energy/energy_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/physics/limits.h"

namespace palpate {
namespace {

using namespace limits::energy;

/// Compliance of the common slack of contradictory rows, which costs |slack|^2 / 2 over this.
constexpr double kSlackCompliance = kJamCompliance;

/// Stiffness at which a row's force is its threshold as soon as it overlaps.
constexpr double kNoSpring = 1e300;

/// a . x, summed from the first element to the last whatever vectors the compiler uses.
double Dot(const Vec6& a, const Vec6& x) {
  double sum = 0.0;
  for (int c = 0; c < 6; ++c) sum += a[c] * x[c];
  return sum;
}

class Newton {
  struct Point {
    Vec6 x;
    double slack = 0.0;
    EnergyAt energy;
    double value;

    Vec6 Force() const { return Vec6::Map(energy.force); }
    double Hessian(int r, int c) const {
      return energy.hessian[r >= c ? r * (r + 1) / 2 + c : c * (c + 1) / 2 + r];
    }
    /// (1 + Hessian) y.
    Vec6 HessianTimes(const Vec6& y) const {
      Vec6 sum = y;
      for (int c = 0; c < 6; ++c) {
        for (int r = 0; r < 6; ++r) sum[r] += Hessian(r, c) * y[c];
      }
      return sum;
    }
  };

 public:
  Newton(const Kernels& kernels, const double* t, const QpRows& rigid,
         std::span<Energy* const> energies, const AlignedColumns& transformed, bool* at_limit)
      : kernels_(kernels),
        rigid_(rigid),
        energies_(energies),
        transformed_(transformed),
        t_(Vec6::Map(t)),
        tolerance_(1e-12 * (1.0 + t_.cwiseAbs().maxCoeff())),
        at_limit_(at_limit),
        thresholds_(std::ranges::any_of(
            energies, [](const Energy* energy) { return energy->yielding.threshold != nullptr; })) {
  }

  QpResult Solve(const double* start, std::span<const int> guess) {
    Point now;
    now.x = Vec6::Map(start);
    Evaluate(now, true);
    int warm[kMaxActiveRows];
    int guesses = static_cast<int>(guess.size());
    std::copy(guess.begin(), guess.end(), warm);
    QpResult result;
    result.status = QpStatus::kIterationLimit;
    int iterations = 0;
    // The first step also leads into the polyhedron, so it may not be shortened.
    bool leads_in = true;
    for (int turn = 0; turn < (thresholds_ ? kTurnsOnSprings : kTurns); ++turn) {
      const Vec6 q = Factorise(now);
      if (!Minimise(q, warm, guesses, result)) break;
      iterations += result.iterations + 1;
      result.iterations = iterations;
      if (result.status == QpStatus::kIterationLimit) return result;
      Point next = At(result);
      Evaluate(next);
      if (SamePieces(now, next, q)) return result;
      if (!leads_in && !Gains(now, next)) Search(now, next);
      leads_in = false;
      now = next;
      Evaluate(now, true);
      guesses = result.active;
      std::copy(result.row, result.row + guesses, warm);
    }
    return thresholds_ ? SolveByLaw(now, {warm, static_cast<std::size_t>(guesses)}, iterations)
                       : result;
  }

 private:
  /// The same without springs: the solver that may hold any row at its threshold takes those that
  /// rest there, and Newton's method what is smooth.
  QpResult SolveByLaw(Point now, std::span<const int> guess, int iterations) {
    LimitedRows rows = GuessLimits();
    by_law_ = true;
    Evaluate(now, true);
    QpResult result;
    for (int turn = 0; iterations <= kIterationsByLaw; ++turn) {
      const Vec6 q = Factorise(now);
      result = MinimiseByLaw(q, rows, guess);
      result.iterations = iterations += result.iterations + 1;
      if (result.status == QpStatus::kIterationLimit) return result;
      Point next = At(result);
      Evaluate(next);
      if (SamePieces(now, next, q)) {
        TakeForces(rows, result);
        return result;
      }
      if (turn > 0) Shorten(now, next);
      now = next;
      Evaluate(now, true);
      guess = result.ActiveRows();
    }
    result.status = QpStatus::kIterationLimit;
    return result;
  }

  static Point At(const QpResult& result) {
    Point point;
    point.x = Vec6::Map(result.x);
    point.slack = result.slack;
    return point;
  }

  /// Only the next quadratic needs the Hessian, not each place that is tried.
  void Evaluate(Point& point, bool with_hessian = false) const {
    const auto add = with_hessian ? kernels_.add_yielding_with_hessian : kernels_.add_yielding;
    point.energy = {};
    for (Energy* energy : energies_) {
      EnergyAt own;
      YieldingRows rows = energy->yielding;
      if (by_law_) rows.threshold = nullptr;
      energy->pushing = add(rows, point.x.data(), kRigid, own);
      energy->force = Vec6::Map(own.force);
      point.energy.twice += own.twice;
      for (int c = 0; c < 6; ++c) point.energy.force[c] += own.force[c];
      for (int k = 0; k < 21; ++k) point.energy.hessian[k] += own.hessian[k];
    }
    const Vec6 away = point.x - t_;
    point.value =
        0.5 * (Dot(away, away) + point.energy.twice + point.slack * point.slack / kSlackCompliance);
  }

  /// For the quadratic at a point, 1/2 x . H x - q . x, returns q, and computes H = L L^T.
  Vec6 Factorise(const Point& point) {
    for (int r = 0; r < 6; ++r) {
      for (int c = 0; c <= r; ++c) {
        double sum = point.Hessian(r, c) + (r == c ? 1.0 : 0.0);
        for (int k = 0; k < c; ++k) sum -= L_[r * 6 + k] * L_[c * 6 + k];
        if (r == c) {
          L_[r * 6 + r] = std::sqrt(sum);
          inverse_diagonal_[r] = 1.0 / L_[r * 6 + r];
        } else {
          L_[r * 6 + c] = sum * inverse_diagonal_[c];
        }
      }
    }
    return point.HessianTimes(point.x) - point.x + t_ + point.Force();
  }

  /// L^-1 q.
  Vec6 Forward(const Vec6& q) const {
    Vec6 y = q;
    for (int r = 0; r < 6; ++r) {
      for (int c = 0; c < r; ++c) y[r] -= L_[r * 6 + c] * y[c];
      y[r] *= inverse_diagonal_[r];
    }
    return y;
  }

  /// Minimises that quadratic under the rigid rows.  Returns false if they would hold the tool
  /// where rows have thresholds: a spring yields femtometres, by which none may miss a row.
  bool Minimise(const Vec6& q, const int* guess, int guesses, QpResult& result) const {
    const Vec6 y = Forward(q);
    result = {};
    Back(y, result.x);
    if (kernels_.rows_hold(rigid_, result.x, thresholds_ ? 0.0 : tolerance_)) return true;
    if (thresholds_) return false;
    double* column[6];
    QpRows rows = rigid_;
    for (std::size_t c = 0; c < 6; ++c) rows.a[c] = column[c] = transformed_[c];
    rows.b = transformed_[6];
    kernels_.transform_rows(rigid_, L_, inverse_diagonal_, 1.0, column, transformed_[6]);
    result = kernels_.solve(y.data(), rows, guess, guesses);
    Back(Vec6::Map(result.x), result.x);
    return true;
  }

  /// Calls visit(rows, first) for the rows of each energy that have thresholds, with the index of
  /// the first of them in the columns: they stand behind the rigid ones.  Returns how many there
  /// are in all.
  template <class Visit>
  int ForEachLimited(Visit visit) const {
    int first = (rigid_.count + 15) & ~15;
    for (Energy* energy : energies_) {
      if (energy->yielding.threshold == nullptr) continue;
      visit(*energy, first);
      first += (energy->yielding.rows.count + 15) & ~15;
    }
    return first;
  }

  /// Guesses that the rows that push with their threshold, at the place last evaluated, do so at
  /// the minimum.
  LimitedRows GuessLimits() const {
    LimitedRows rows{{}, transformed_[6], transformed_[7], at_limit_, 0};
    for (std::size_t c = 0; c < 6; ++c) rows.a[c] = transformed_[c];
    const int rigid = (rigid_.count + 15) & ~15;
    std::fill_n(at_limit_, rigid, false);
    std::fill_n(transformed_[7], rigid, std::numeric_limits<double>::infinity());
    rows.count = ForEachLimited([&](const Energy& energy, int first) {
      const YieldingRows& yielding = energy.yielding;
      const int padded = (yielding.rows.count + 15) & ~15;
      for (int i = 0; i < padded; ++i) {
        const bool real = i < yielding.rows.count;
        transformed_[7][first + i] = real ? kThresholdScale * yielding.threshold[i] : 0.0;
        at_limit_[first + i] = real && yielding.push[i] >= yielding.threshold[i];
      }
    });
    return rows;
  }

  /// Minimises that quadratic and the thresholds' costs under the rigid rows.
  QpResult MinimiseByLaw(const Vec6& q, const LimitedRows& rows, std::span<const int> guess) const {
    const auto transform = [&](const QpRows& from, int first) {
      double* column[6];
      for (std::size_t c = 0; c < 6; ++c) column[c] = transformed_[c] + first;
      kernels_.transform_rows(from, L_, inverse_diagonal_, kThresholdScale, column,
                              transformed_[6] + first);
    };
    transform(rigid_, 0);
    ForEachLimited([&](const Energy& energy, int first) {
      const QpRows& of = energy.yielding.rows;
      transform(of, first);
      for (int i = of.count; i % 16 != 0; ++i) {
        for (std::size_t c = 0; c < 6; ++c) transformed_[c][first + i] = 0.0;
        transformed_[6][first + i] = -1e300;
      }
    });
    const Vec6 y = kThresholdScale * Forward(q);
    QpResult result =
        kernels_.solve_limited(y.data(), rows, guess.data(), static_cast<int>(guess.size()));
    Back(Vec6::Map(result.x) / kThresholdScale, result.x);
    result.slack /= kThresholdScale;
    for (int i = 0; i < result.active; ++i) result.multiplier[i] /= kThresholdScale;
    return result;
  }

  /// Adds the forces of thresholds to those of the rows, and leaves the rigid rows to the result.
  void TakeForces(const LimitedRows& rows, QpResult& result) const {
    ForEachLimited([&](Energy& energy, int first) {
      const YieldingRows& yielding = energy.yielding;
      energy.pushing = 0;
      for (int i = 0; i < yielding.rows.count; ++i) {
        double force = rows.at_limit[first + i] ? yielding.threshold[i] : 0.0;
        for (int k = 0; k < result.active; ++k) {
          if (result.row[k] == first + i) force = result.multiplier[k];
        }
        yielding.push[i] += force;
        energy.pushing += yielding.push[i] > 0.0 ? 1 : 0;
        for (int c = 0; c < 6; ++c) energy.force[c] += force * yielding.rows.a[c][i];
      }
    });
    int rigid = 0;
    for (int k = 0; k < result.active; ++k) {
      if (result.row[k] >= rigid_.count) continue;
      result.row[rigid] = result.row[k];
      result.multiplier[rigid++] = result.multiplier[k];
    }
    result.active = rigid;
  }

  /// x = L^-T y.
  void Back(const Vec6& y, double* x) const {
    for (int r = 6 - 1; r >= 0; --r) {
      x[r] = y[r];
      for (int c = r + 1; c < 6; ++c) x[r] -= L_[c * 6 + r] * x[c];
      x[r] *= inverse_diagonal_[r];
    }
  }

  /// Returns whether the gradient at `next` equals that of the quadratic that led there.
  bool SamePieces(const Point& now, const Point& next, const Vec6& q) const {
    double stiffness = 1.0, size = 0.0;
    for (int r = 0; r < 6; ++r) {
      stiffness += now.Hessian(r, r);
      size += std::fabs(q[r]);
    }
    // Sum of the rounding errors of terms that nearly cancel.
    const double largest = next.x.cwiseAbs().maxCoeff();
    const double rounding = (by_law_ ? 0.0 : tolerance_) + kRounding * (size + stiffness * largest);
    return !((Gradient(next) - (now.HessianTimes(next.x) - q)).cwiseAbs().array() > rounding).any();
  }

  /// The cost of all thresholds: sum of P s.
  double CostOfThresholds(const Vec6& x) const {
    double twice = 0.0;
    ForEachLimited([&](const Energy& energy, int) {
      YieldingRows rows = energy.yielding;
      EnergyAt all, smooth;
      kernels_.add_yielding(rows, x.data(), kNoSpring, all);
      rows.threshold = nullptr;
      kernels_.add_yielding(rows, x.data(), kNoSpring, smooth);
      twice += all.twice - smooth.twice;
    });
    return 0.5 * twice;
  }

  /// Halves a step from `now` until it gains enough (Armijo's rule for a convex term beside a
  /// smooth one: Tseng & Yun, Math. Programming 117 (2009) 387-423).
  void Shorten(const Point& now, Point& next) const {
    const Point end = next;
    const double cost = CostOfThresholds(now.x);
    const double promised = Slope(now, now, end) + CostOfThresholds(end.x) - cost;
    double part = 1.0;
    for (int i = 0; i < kLineSearchLimit; ++i) {
      if (next.value + CostOfThresholds(next.x) <=
          now.value + cost + kLeastGain * part * promised) {
        return;
      }
      part *= 0.5;
      next.x = now.x + part * (end.x - now.x);
      next.slack = now.slack + part * (end.slack - now.slack);
      Evaluate(next);
    }
  }

  Vec6 Gradient(const Point& at) const { return at.x - t_ - at.Force(); }

  /// Slope at `at`, in the direction from `from` to `to`.
  double Slope(const Point& at, const Point& from, const Point& to) const {
    const Vec6 gradient = Gradient(at), way = to.x - from.x;
    return Dot(gradient, way) + at.slack * (to.slack - from.slack) / kSlackCompliance;
  }

  bool Gains(const Point& now, const Point& next) const {
    return next.value <= now.value + kLeastGain * Slope(now, now, next) ||
           Slope(next, now, next) <= 0.0;
  }

  /// Puts `next` where the sum stops falling on the way from `now`, by bisection, since
  /// the slope is monotone.
  void Search(const Point& now, Point& next) const {
    const Point end = next;
    const double enough = kSlopeLeft * Slope(now, now, end);
    double low = 0.0, high = 1.0;
    for (int i = 0; i < kLineSearchLimit; ++i) {
      const double part = 0.5 * (low + high);
      next.x = now.x + part * (end.x - now.x);
      next.slack = now.slack + part * (end.slack - now.slack);
      Evaluate(next);
      const double slope = Slope(next, now, end);
      if (slope <= 0.0 && slope >= enough) return;
      (slope > 0.0 ? high : low) = part;
    }
  }

  const Kernels& kernels_;
  const QpRows& rigid_;
  std::span<Energy* const> energies_;
  const AlignedColumns& transformed_;
  Vec6 t_;
  double L_[6 * 6];
  double inverse_diagonal_[6];
  double tolerance_;
  bool* at_limit_;
  bool thresholds_;
  bool by_law_ = false;  ///< whether thresholds are rows with limits, and no springs
};

}  // namespace

QpResult EnergySolver::Solve(const Kernels& kernels, const double* t, const QpRows& rigid,
                             std::span<Energy* const> energies, const double* start,
                             std::span<const int> guess) noexcept {
  return Newton(kernels, t, rigid, energies, transformed_, at_limit_.get()).Solve(start, guess);
}

}  // namespace palpate
