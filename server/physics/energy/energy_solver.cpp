#include "server/physics/energy/energy_solver.h"

#include <algorithm>
#include <cmath>

#include "server/physics/limits.h"

namespace palpate {
namespace {

using namespace limits::energy;

/// Compliance of the common slack of contradictory rows, which costs |slack|^2 / 2 over this.
constexpr double kSlackCompliance = kJamCompliance;

double Entry(const double* lower, int r, int c) {
  return r >= c ? lower[r * (r + 1) / 2 + c] : lower[c * (c + 1) / 2 + r];
}

template <int N>
class Newton {
 public:
  Newton(const Kernels& kernels, const double* t, const QpRows& rigid,
         std::span<Energy* const> energies, const AlignedColumns& transformed, double* force)
      : kernels_(kernels),
        rigid_(rigid),
        energies_(energies),
        transformed_(transformed),
        force_(force) {
    double largest = 0.0;
    for (int i = 0; i < N; ++i) {
      t_[i] = t[i];
      largest = std::max(largest, std::fabs(t[i]));
    }
    tolerance_ = 1e-12 * (1.0 + largest);
    thresholds_ = std::any_of(energies.begin(), energies.end(),
                              [](const Energy* energy) { return energy->HasThresholds(); });
  }

  QpResult Solve(const double* start, std::span<const int> guess) {
    QpResult result;
    Point now;
    std::copy(start, start + N, now.x);
    Evaluate(now);
    EvaluateHessian(now);
    int warm[kMaxActiveRows], iterations = 0;
    int guesses = static_cast<int>(guess.size());
    std::copy(guess.begin(), guess.end(), warm);
    // The first step also leads into the polyhedron, so it may not be shortened.
    bool leads_in = true;
    for (int turn = 0, of_stage = 0; turn < kTurns; ++turn, ++of_stage) {
      if (thresholds_ && turn == kTurnsAtOnce) {
        springs_ = {kSoftest, kSoftest};
        Evaluate(now);
        EvaluateHessian(now);
        of_stage = 0;
      }
      double q[N];
      Factorise(now, q);
      result = Minimise(q, warm, guesses);
      iterations += result.iterations + 1;
      result.iterations = iterations;
      if (result.status == QpStatus::kIterationLimit) return result;
      Point next;
      std::copy(result.x, result.x + N, next.x);
      next.slack = result.slack;
      springs_.on = springs_.stiffness;
      Evaluate(next);
      const bool ends = SamePieces(now, next, q);
      const bool softened = thresholds_ && springs_.stiffness < kRigid;
      if (ends && !softened) {
        std::copy(next.energy.force, next.energy.force + N, force_);
        return result;
      }
      if (softened && (ends || of_stage >= kTurnsOfStage)) {
        // The first turn of a stage assumes on their springs those rows that were so in the
        // last stage, for which it is exact.  With the stiffer springs they no longer are at
        // the x of the softer ones.
        springs_.stiffness *= kStiffen;
        Evaluate(next);
        of_stage = -1;
        leads_in = true;
      } else if (!leads_in && !Gains(now, next)) {
        Search(now, next);
      } else {
        leads_in = false;
      }
      now = next;
      EvaluateHessian(now);
      guesses = result.active;
      std::copy(result.row, result.row + guesses, warm);
    }
    result.status = QpStatus::kIterationLimit;
    return result;
  }

 private:
  static constexpr int kEntries = N * (N + 1) / 2;

  struct Point {
    double x[N];
    double slack = 0.0;
    EnergyAt energy;
    double value;
  };

  void Evaluate(Point& point) const {
    point.energy = {};
    for (Energy* energy : energies_) {
      energy->Add(kernels_, point.x, N, springs_, point.energy);
    }
    double distance = 0.0;
    for (int r = 0; r < N; ++r) distance += (point.x[r] - t_[r]) * (point.x[r] - t_[r]);
    point.value =
        0.5 * (distance + point.energy.twice + point.slack * point.slack / kSlackCompliance);
  }

  /// Evaluated separately, because only the next quadratic needs it.
  void EvaluateHessian(Point& point) const {
    std::fill(point.energy.hessian, point.energy.hessian + kEntries, 0.0);
    for (const Energy* energy : energies_) {
      energy->AddHessian(kernels_, point.x, N, springs_, point.energy);
    }
  }

  /// H x, row r.
  static double HessianTimes(const Point& point, const double* x, int r) {
    double sum = x[r];
    for (int c = 0; c < N; ++c) sum += Entry(point.energy.hessian, r, c) * x[c];
    return sum;
  }

  /// Computes the quadratic at a point, 1/2 x . H x - q . x, and H = L L^T.
  void Factorise(const Point& point, double* q) {
    for (int r = 0; r < N; ++r) {
      q[r] = HessianTimes(point, point.x, r) - point.x[r] + t_[r] + point.energy.force[r];
    }
    for (int r = 0; r < N; ++r) {
      for (int c = 0; c <= r; ++c) {
        double sum = Entry(point.energy.hessian, r, c) + (r == c ? 1.0 : 0.0);
        for (int k = 0; k < c; ++k) sum -= L_[r * N + k] * L_[c * N + k];
        if (r == c) {
          L_[r * N + r] = std::sqrt(sum);
          inverse_diagonal_[r] = 1.0 / L_[r * N + r];
        } else {
          L_[r * N + c] = sum * inverse_diagonal_[c];
        }
      }
    }
  }

  /// Minimises that quadratic under the rigid rows.
  QpResult Minimise(const double* q, const int* guess, int guesses) const {
    double y[N];
    for (int r = 0; r < N; ++r) {
      double sum = q[r];
      for (int c = 0; c < r; ++c) sum -= L_[r * N + c] * y[c];
      y[r] = sum * inverse_diagonal_[r];
    }
    QpResult result;
    Back(y, result.x);
    // Femtometres press a threshold's spring, and rows may be violated by less only: their QP is
    // solved in other units.
    const double scale = thresholds_ ? kThresholdScale : 1.0;
    if (kernels_.rows_hold(rigid_, N, result.x, tolerance_ / scale)) return result;
    double* column[6] = {};
    QpRows rows = rigid_;
    for (std::size_t c = 0; c < N; ++c) rows.a[c] = column[c] = transformed_[c];
    rows.b = transformed_[6];
    kernels_.transform_rows(rigid_, N, L_, inverse_diagonal_, scale, column, transformed_[6]);
    for (double& value : y) value *= scale;
    result = kernels_.solve(y, N, rows, guess, guesses);
    for (int r = 0; r < N; ++r) y[r] = result.x[r] / scale;
    Back(y, result.x);
    result.slack /= scale;
    for (int i = 0; i < result.active; ++i) result.multiplier[i] /= scale;
    return result;
  }

  /// x = L^-T y.
  void Back(const double* y, double* x) const {
    for (int r = N - 1; r >= 0; --r) {
      double sum = y[r];
      for (int c = r + 1; c < N; ++c) sum -= L_[c * N + r] * x[c];
      x[r] = sum * inverse_diagonal_[r];
    }
  }

  /// Returns whether the gradient at `next` equals that of the quadratic that led there.
  bool SamePieces(const Point& now, const Point& next, const double* q) const {
    double stiffness = 1.0, size = 0.0, largest = 0.0;
    for (int r = 0; r < N; ++r) {
      stiffness += Entry(now.energy.hessian, r, r);
      size += std::fabs(q[r]);
      largest = std::max(largest, std::fabs(next.x[r]));
    }
    // Sum of the rounding errors of terms that nearly cancel.
    const double rounding = tolerance_ + kRounding * (size + stiffness * largest);
    for (int r = 0; r < N; ++r) {
      const double gradient = next.x[r] - t_[r] - next.energy.force[r];
      const double difference = gradient - (HessianTimes(now, next.x, r) - q[r]);
      if (std::fabs(difference) > rounding) return false;
    }
    return true;
  }

  /// Slope at `at`, in the direction from `from` to `to`.
  double Slope(const Point& at, const Point& from, const Point& to) const {
    double slope = at.slack * (to.slack - from.slack) / kSlackCompliance;
    for (int r = 0; r < N; ++r) {
      slope += (at.x[r] - t_[r] - at.energy.force[r]) * (to.x[r] - from.x[r]);
    }
    return slope;
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
      for (int r = 0; r < N; ++r) next.x[r] = now.x[r] + part * (end.x[r] - now.x[r]);
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
  double* force_;
  double t_[N];
  double L_[N * N];
  double inverse_diagonal_[N];
  double tolerance_;
  bool thresholds_;
  Springs springs_;
};

}  // namespace

QpResult EnergySolver::Solve(const Kernels& kernels, int unknowns, const double* t,
                             const QpRows& rigid, std::span<Energy* const> energies,
                             const double* start, std::span<const int> guess) noexcept {
  if (unknowns == 6)
    return Newton<6>(kernels, t, rigid, energies, transformed_, force_).Solve(start, guess);
  return Newton<3>(kernels, t, rigid, energies, transformed_, force_).Solve(start, guess);
}

}  // namespace palpate
