#pragma once

#include <cstdint>

#include "server/physics/simd/kernels.h"

namespace palpate {

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

}  // namespace palpate
