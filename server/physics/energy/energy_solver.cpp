#include "server/physics/energy/energy_solver.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/physics/limits.h"

namespace palpate {
namespace {

using namespace limits::energy;

/// Stiffness at which a row's force is its threshold as soon as it overlaps.
constexpr double kNoSpring = 1e300;

int Padded(int rows) {
  return (rows + 15) & ~15;
}

class Newton {
  struct Point {
    Vec6 x;
    double slack = 0.0;
    double value = 0.0;
    Vec6 force = Vec6::Zero();
    Mat6 hessian = Mat6::Identity();  ///< with the coupling's
  };

 public:
  Newton(const Kernels& kernels, const double* t, const QpRows& rigid,
         std::span<Energy* const> energies, const AlignedColumns& columns, bool* at_limit)
      : kernels_(kernels),
        rigid_(rigid),
        energies_(energies),
        limited_{{}, columns[6], columns[7], at_limit, 0},
        limit_(columns[7]),
        t_(Vec6::Map(t)),
        tolerance_(1e-12 * (1.0 + t_.lpNorm<Eigen::Infinity>())),
        thresholds_(std::ranges::any_of(
            energies, [](const Energy* energy) { return energy->thresholds() != nullptr; })) {
    for (std::size_t c = 0; c < 6; ++c) limited_.a[c] = columns[c];
  }

  QpResult Solve(const double* start, std::span<const int> guess) {
    result_.active = static_cast<int>(guess.size());
    std::copy(guess.begin(), guess.end(), result_.row);
    Point now{Vec6::Map(start)};
    Evaluate(now, true);
    bool ends = Iterate(now, thresholds_ ? kIterationsOnSprings : kIterations);
    if (!ends && thresholds_) {
      GuessLimits();
      by_law_ = true;
      Evaluate(now, true);
      if (ends = Iterate(now, kIterations); ends) TakeForces();
    }
    if (!ends) result_.status = QpStatus::kIterationLimit;
    return result_;
  }

 private:
  /// Minimises the quadratic at a place, then that at its minimum, and so on, until a minimum has
  /// the same pieces as its quadratic.  Returns whether it ends within so many iterations, of this
  /// and of the QP.
  bool Iterate(Point& now, int most) {
    for (bool first = true; result_.iterations < most; first = false) {
      const Vec6 q = Factorise(now);
      if (!Minimise(q)) return false;
      Point next{Vec6::Map(result_.x), result_.slack};
      Evaluate(next);
      // A step of picometres is the rounding of rows that just touch.
      const bool stays = by_law_ && !first && (next.x - now.x).cwiseAbs().maxCoeff() <= tolerance_;
      if (stays || SamePieces(now, next, q)) return true;
      // The first step also leads into the polyhedron, so it may not be shortened.
      if (!first) by_law_ ? Shorten(now, next) : Search(now, next);
      now = next;
      Evaluate(now, true);
    }
    return false;
  }

  /// Only the next quadratic needs the Hessian, not each place that is tried.
  void Evaluate(Point& point, bool with_hessian = false) const {
    const Evaluation by{kernels_, by_law_ ? 0.0 : kRigid, with_hessian};
    const Vec6 away = point.x - t_;
    double twice = away.squaredNorm() + point.slack * point.slack / kJamCompliance;
    point.force.setZero();
    point.hessian.setIdentity();
    for (Energy* energy : energies_) {
      EnergyAt own;
      energy->pushing = energy->Add(by, point.x.data(), own);
      energy->force = Vec6::Map(own.force);
      twice += own.twice;
      point.force += energy->force;
      const double* entry = own.hessian;
      for (int r = 0; r < 6; ++r) {
        for (int c = 0; c <= r; ++c) point.hessian(r, c) += *entry++;
      }
    }
    point.hessian.triangularView<Eigen::StrictlyUpper>() = point.hessian.transpose();
    point.value = 0.5 * twice;
  }

  /// For the quadratic at a point, 1/2 x . H x - q . x, returns q, and computes H = L L^T.
  Vec6 Factorise(const Point& point) {
    L_ = point.hessian.llt().matrixL();
    inverse_diagonal_ = L_.diagonal().cwiseInverse();
    return point.hessian * point.x - point.x + t_ + point.force;
  }

  /// L^-T y.
  Vec6 Back(const Vec6& y) const { return L_.transpose().triangularView<Eigen::Upper>().solve(y); }

  /// Minimises the quadratic under the rigid rows.  Returns false if the QP does not end, or if a
  /// rigid row would hold a tool on springs: these yield by femtometres, and no row may be violated
  /// by as much.
  bool Minimise(const Vec6& q) {
    const Vec6 y = L_.triangularView<Eigen::Lower>().solve(q);
    QpResult found{};
    if (by_law_) {
      found = SolveLimited(kThresholdScale * y);
    } else {
      Vec6::Map(found.x) = Back(y);
      if (!kernels_.rows_hold(rigid_, found.x, thresholds_ ? 0.0 : tolerance_)) {
        if (thresholds_) return false;
        Transform(rigid_, 0, 1.0);
        QpRows rows{{}, limited_.b, rigid_.count};
        std::copy_n(limited_.a, 6, rows.a);
        found = kernels_.solve(y.data(), rows, result_.row, result_.active);
        Vec6::Map(found.x) = Back(Vec6::Map(found.x));
      }
    }
    found.iterations += result_.iterations + 1;
    result_ = found;
    return result_.status != QpStatus::kIterationLimit;
  }

  /// The same without springs: a row may rest below its threshold.
  QpResult SolveLimited(const Vec6& y) {
    Transform(rigid_, 0, kThresholdScale);
    ForEachLimited([&](const Energy&, const YieldingRows& rows, int first) {
      Transform(rows.rows, first, kThresholdScale);
    });
    QpResult found = kernels_.solve_limited(y.data(), limited_, result_.row, result_.active);
    Vec6::Map(found.x) = Back(Vec6::Map(found.x) / kThresholdScale);
    found.slack /= kThresholdScale;
    for (int i = 0; i < found.active; ++i) found.multiplier[i] /= kThresholdScale;
    return found;
  }

  void Transform(const QpRows& rows, int first, double scale) const {
    double* column[6];
    for (std::size_t c = 0; c < 6; ++c) column[c] = limited_.a[c] + first;
    kernels_.transform_rows(rows, L_.data(), inverse_diagonal_.data(), scale, column,
                            limited_.b + first);
  }

  /// Calls visit(energy, rows, first) for each energy with thresholds.  In the columns its rows
  /// begin at `first`, behind the rigid ones.  Returns how many rows the columns hold.
  template <class Visit>
  int ForEachLimited(Visit visit) const {
    int first = Padded(rigid_.count);
    for (Energy* energy : energies_) {
      const YieldingRows* rows = energy->thresholds();
      if (rows == nullptr) continue;
      visit(*energy, *rows, first);
      first += Padded(rows->rows.count);
    }
    return first;
  }

  /// The first guess: a row that pushes with its threshold at the place last evaluated does so at
  /// the minimum.
  void GuessLimits() {
    const int rigid = Padded(rigid_.count);
    std::fill_n(limited_.at_limit, rigid, false);
    std::fill_n(limit_, rigid, std::numeric_limits<double>::infinity());
    limited_.count = ForEachLimited([&](const Energy&, const YieldingRows& rows, int first) {
      for (int i = 0; i < Padded(rows.rows.count); ++i) {
        const bool real = i < rows.rows.count;
        limit_[first + i] = real ? kThresholdScale * rows.threshold[i] : 0.0;
        limited_.at_limit[first + i] = real && rows.push[i] >= rows.threshold[i];
      }
    });
  }

  /// Moves the forces of thresholds from the result to their energies.
  void TakeForces() {
    ForEachLimited([&](Energy& energy, const YieldingRows& rows, int first) {
      energy.pushing = 0;
      for (int i = 0; i < rows.rows.count; ++i) {
        double force = limited_.at_limit[first + i] ? rows.threshold[i] : 0.0;
        for (int k = 0; k < result_.active; ++k) {
          if (result_.row[k] == first + i) force = result_.multiplier[k];
        }
        rows.push[i] += force;
        energy.pushing += rows.push[i] > 0.0 ? 1 : 0;
        for (int c = 0; c < 6; ++c) energy.force[c] += force * rows.rows.a[c][i];
      }
    });
    int rigid = 0;
    for (int k = 0; k < result_.active; ++k) {
      if (result_.row[k] >= rigid_.count) continue;
      result_.row[rigid] = result_.row[k];
      result_.multiplier[rigid++] = result_.multiplier[k];
    }
    result_.active = rigid;
  }

  /// Returns whether the gradient at `next` is that of the quadratic at `now`.
  bool SamePieces(const Point& now, const Point& next, const Vec6& q) const {
    const double stiffness = now.hessian.trace() - 5.0, size = q.lpNorm<1>();
    // The rounding of terms that nearly cancel.
    const double largest = next.x.lpNorm<Eigen::Infinity>();
    const double rounding = (by_law_ ? 0.0 : tolerance_) + kRounding * (size + stiffness * largest);
    return ((Gradient(next) - (now.hessian * next.x - q)).array().abs() <= rounding).all();
  }

  /// The cost of thresholds without springs: sum of P s.
  double CostOfThresholds(const Vec6& x) const {
    double twice = 0.0;
    for (const Energy* energy : energies_) {
      if (energy->thresholds() == nullptr) continue;
      EnergyAt all, smooth;
      energy->Add({kernels_, kNoSpring, false}, x.data(), all);
      energy->Add({kernels_, 0.0, false}, x.data(), smooth);
      twice += all.twice - smooth.twice;
    }
    return 0.5 * twice;
  }

  /// Halves a step without springs until it gains enough (Armijo's rule for a convex term beside a
  /// smooth one: Tseng & Yun, Math. Programming 117 (2009) 387-423), or is a rounding.
  void Shorten(const Point& now, Point& next) const {
    const Point end = next;
    const double cost = CostOfThresholds(now.x), least = now.value + cost;
    const double promised = Slope(now, now, end) + CostOfThresholds(end.x) - cost;
    for (double fraction = 1.0;
         fraction > kRounding &&
         next.value + CostOfThresholds(next.x) > least + kLeastGain * fraction * promised;) {
      Go(now, end, fraction *= 0.5, next);
    }
  }

  /// If the sum has not fallen enough at `next`, and rises there, moves `next` to where it stops
  /// falling on the path from `now`: by bisection, since the slope is monotone.
  void Search(const Point& now, Point& next) const {
    const Point end = next;
    const double slope = Slope(now, now, end);
    if (next.value <= now.value + kLeastGain * slope || Slope(next, now, end) <= 0.0) return;
    double low = 0.0, high = 1.0;
    while (high - low > kRounding * high) {
      const double fraction = 0.5 * (low + high);
      Go(now, end, fraction, next);
      const double here = Slope(next, now, end);
      if (here <= 0.0 && here >= kLeastGain * slope) return;
      (here > 0.0 ? high : low) = fraction;
    }
  }

  /// Puts `next` at a fraction of the path from one point to another.
  void Go(const Point& from, const Point& to, double fraction, Point& next) const {
    next.x = from.x + fraction * (to.x - from.x);
    next.slack = from.slack + fraction * (to.slack - from.slack);
    Evaluate(next);
  }

  Vec6 Gradient(const Point& at) const { return at.x - t_ - at.force; }

  /// Slope at `at`, in the direction from `from` to `to`.
  double Slope(const Point& at, const Point& from, const Point& to) const {
    return Gradient(at).dot(to.x - from.x) + at.slack * (to.slack - from.slack) / kJamCompliance;
  }

  const Kernels& kernels_;
  const QpRows& rigid_;
  std::span<Energy* const> energies_;
  LimitedRows limited_;  ///< the rows in y = L^T x: the rigid ones, then those with thresholds
  double* limit_;        ///< of each of them
  Vec6 t_;
  Mat6 L_;
  Vec6 inverse_diagonal_;
  double tolerance_;
  bool thresholds_;
  bool by_law_ = false;  ///< whether thresholds are rows with limits, and no springs
  QpResult result_;      ///< of the last quadratic; at first the guess
};

}  // namespace

QpResult EnergySolver::Solve(const Kernels& kernels, const double* t, const QpRows& rigid,
                             std::span<Energy* const> energies, const double* start,
                             std::span<const int> guess) noexcept {
  return Newton(kernels, t, rigid, energies, columns_, at_limit_.get()).Solve(start, guess);
}

}  // namespace palpate
