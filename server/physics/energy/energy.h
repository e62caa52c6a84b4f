#pragma once

#include <cstdint>

#include "server/physics/simd/kernels.h"

namespace palpate {

/// A convex energy of a step x = [v; rho phi] beside that of the coupling: what pushes the tool,
/// and is no wall to it.  All over the coupling's stiffness k_t, so that forces are lengths.  A new
/// kind of force is a class that derives from this (soft leaves: rows/soft_rows.h; a bur:
/// cut/cut_rows.h) and its place in Energies (solve/energies.h).  Functions are real-time: no
/// allocation, lock, log or clock; and deterministic.
class Energy {
 public:
  virtual ~Energy() = default;
  /// Adds what it is at x: its energy, and its force, the gradient's opposite.  What the energy
  /// reports of itself is that of the last call, which is at the result.
  virtual void Add(const Kernels& kernels, const double* x, int unknowns, const Springs& springs,
                   EnergyAt& at) noexcept = 0;
  /// Adds its Hessian at x; of a kink that of either side.
  virtual void AddHessian(const Kernels& kernels, const double* x, int unknowns,
                          const Springs& springs, EnergyAt& at) const noexcept = 0;
  /// Whether it has thresholds, up to which it is rigid (Springs).
  virtual bool HasThresholds() const noexcept { return false; }
};

}  // namespace palpate
