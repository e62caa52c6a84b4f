#include "server/physics/energy/energy_solver.h"

#include <algorithm>
#include <cmath>

#include "server/physics/limits.h"

namespace palpate {
namespace {

using namespace limits::energy;

/// Compliance of the common slack of contradictory rows, which costs |slack|^2 / 2 over this.
constexpr double kSlackCompliance = kJamCompliance;

/// a . x, summed from the first element to the last whatever vectors the compiler uses.
double Dot(const Vec6& a, const Vec6& x) {
  double sum = 0.0;
  for (int c = 0; c < 6; ++c) sum += a[c] * x[c];
  return sum;
}

class Newton {
 public:
  Newton(const Kernels& kernels, const double* t, const QpRows& rigid,
         std::span<Energy* const> energies, const AlignedColumns& transformed)
      : kernels_(kernels),
        rigid_(rigid),
        energies_(energies),
        transformed_(transformed),
        t_(Vec6::Map(t)),
        tolerance_(1e-12 * (1.0 + t_.cwiseAbs().maxCoeff())),
        thresholds_(std::ranges::any_of(
            energies, [](const Energy* energy) { return energy->yielding.threshold != nullptr; })) {
  }

  QpResult Solve(const double* start, std::span<const int> guess) {
    QpResult result;
    Point now;
    now.x = Vec6::Map(start);
    Evaluate(now, true);
    int warm[kMaxActiveRows], iterations = 0;
    int guesses = static_cast<int>(guess.size());
    std::copy(guess.begin(), guess.end(), warm);
    // The first step also leads into the polyhedron, so it may not be shortened.
    bool leads_in = true;
    for (int turn = 0, of_stage = 0; turn < kTurns; ++turn, ++of_stage) {
      if (thresholds_ && turn == kTurnsAtOnce) {
        springs_ = {kSoftest, kSoftest};
        Evaluate(now, true);
        of_stage = 0;
      }
      const Vec6 q = Factorise(now);
      result = Minimise(q, warm, guesses);
      iterations += result.iterations + 1;
      result.iterations = iterations;
      if (result.status == QpStatus::kIterationLimit) return result;
      Point next;
      next.x = Vec6::Map(result.x);
      next.slack = result.slack;
      springs_.on = springs_.stiffness;
      Evaluate(next);
      const bool ends = SamePieces(now, next, q);
      const bool softened = thresholds_ && springs_.stiffness < kRigid;
      if (ends && !softened) return result;
      if (softened && (ends || of_stage >= kTurnsOfStage)) {
        // The first turn of a stage assumes on their springs those rows that were so in the
        // last stage, for which it is exact.  With the stiffer springs they no longer are at
        // the x of the softer ones.
        springs_.stiffness *= kStiffen;
        of_stage = -1;
        leads_in = true;
      } else if (!leads_in && !Gains(now, next)) {
        Search(now, next);
      } else {
        leads_in = false;
      }
      now = next;
      Evaluate(now, true);
      guesses = result.active;
      std::copy(result.row, result.row + guesses, warm);
    }
    result.status = QpStatus::kIterationLimit;
    return result;
  }

 private:
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

  /// Only the next quadratic needs the Hessian, not each place that is tried.
  void Evaluate(Point& point, bool with_hessian = false) const {
    const auto add = with_hessian ? kernels_.add_yielding_with_hessian : kernels_.add_yielding;
    point.energy = {};
    for (Energy* energy : energies_) {
      EnergyAt own;
      energy->pushing = add(energy->yielding, point.x.data(), springs_, own);
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

  /// Minimises that quadratic under the rigid rows.
  QpResult Minimise(const Vec6& q, const int* guess, int guesses) const {
    Vec6 y = q;
    for (int r = 0; r < 6; ++r) {
      for (int c = 0; c < r; ++c) y[r] -= L_[r * 6 + c] * y[c];
      y[r] *= inverse_diagonal_[r];
    }
    QpResult result;
    Back(y, result.x);
    // Femtometres press a threshold's spring, and rows may be violated by less only: their QP is
    // solved in other units.
    const double scale = thresholds_ ? kThresholdScale : 1.0;
    if (kernels_.rows_hold(rigid_, result.x, tolerance_ / scale)) return result;
    double* column[6];
    QpRows rows = rigid_;
    for (std::size_t c = 0; c < 6; ++c) rows.a[c] = column[c] = transformed_[c];
    rows.b = transformed_[6];
    kernels_.transform_rows(rigid_, L_, inverse_diagonal_, scale, column, transformed_[6]);
    y *= scale;
    result = kernels_.solve(y.data(), rows, guess, guesses);
    Back(Vec6::Map(result.x) / scale, result.x);
    result.slack /= scale;
    for (int i = 0; i < result.active; ++i) result.multiplier[i] /= scale;
    return result;
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
    const double rounding = tolerance_ + kRounding * (size + stiffness * largest);
    return !((Gradient(next) - (now.HessianTimes(next.x) - q)).cwiseAbs().array() > rounding).any();
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
  bool thresholds_;
  Springs springs_;
};

}  // namespace

QpResult EnergySolver::Solve(const Kernels& kernels, const double* t, const QpRows& rigid,
                             std::span<Energy* const> energies, const double* start,
                             std::span<const int> guess) noexcept {
  return Newton(kernels, t, rigid, energies, transformed_).Solve(start, guess);
}

}  // namespace palpate
