#pragma once

#include <Eigen/Core>

#include "server/physics/simd/kernels.h"

namespace palpate {

template <int N>
using Vec = Eigen::Matrix<double, N, 1>;
using Vec6 = Vec<6>;

/// a . x, summed from the first element to the last whatever vectors the compiler uses.
template <int N>
double Dot(const Vec<N>& a, const Vec<N>& x) {
  double sum = 0.0;
  for (int c = 0; c < N; ++c) sum += a[c] * x[c];
  return sum;
}

/// A convex energy of a step x = [v; rho phi], added to that of the coupling: something that pushes
/// the tool but does not block it.  Everything is divided by the coupling's stiffness k_t, so
/// forces are lengths.  A new kind of force derives from this class (soft leaves: rows/soft_rows.h;
/// a bur: cut/cut_rows.h) and is entered in Energies (solve/energies.h).  Functions are real-time
/// (no allocation, lock, log or clock) and deterministic.
class Energy {
 public:
  virtual ~Energy() = default;
  /// Adds the energy at x, and its force, the negative gradient.  What a derived class reports
  /// about itself refers to the last call, which is made at the solver's result.
  virtual void Add(const Kernels& kernels, const double* x, int unknowns, const Springs& springs,
                   EnergyAt& at) noexcept = 0;
  /// Adds its Hessian at x; at a kink, that of either side.
  virtual void AddHessian(const Kernels& kernels, const double* x, int unknowns,
                          const Springs& springs, EnergyAt& at) const noexcept = 0;
  /// Returns whether it has thresholds, up to which it is rigid (Springs).
  virtual bool HasThresholds() const noexcept { return false; }
};

/// An energy whose rows yield one by one.
class YieldingEnergy : public Energy {
 public:
  void Add(const Kernels& kernels, const double* x, int unknowns, const Springs& springs,
           EnergyAt& at) noexcept override {
    EnergyAt mine;
    pushing_ = kernels.add_yielding(Yielding(), unknowns, x, springs, mine);
    force_ = Vec6::Map(mine.force);
    at.twice += mine.twice;
    for (int c = 0; c < unknowns; ++c) at.force[c] += mine.force[c];
  }
  void AddHessian(const Kernels& kernels, const double* x, int unknowns, const Springs& springs,
                  EnergyAt& at) const noexcept override {
    kernels.add_yielding_hessian(Yielding(), unknowns, x, springs, at);
  }
  /// The number of rows that push at the solver's result.
  int pushing() const { return pushing_; }
  /// The sum of their forces there, on [v; rho phi], over the coupling's stiffness [m].
  const Vec6& force() const { return force_; }

 private:
  virtual YieldingRows Yielding() const noexcept = 0;

  Vec6 force_ = Vec6::Zero();
  int pushing_ = 0;
};

}  // namespace palpate
