#pragma once

#include <Eigen/Core>

#include "server/physics/simd/kernels.h"

namespace palpate {

using Vec6 = Eigen::Matrix<double, 6, 1>;

/// A convex energy of a step x = [v; rho phi], added to that of the coupling: something that pushes
/// the tool but does not block it, as rows that yield one by one.  Everything is divided by the
/// coupling's stiffness k_t, so forces are lengths.  A new kind of force derives from this struct
/// (soft leaves: rows/soft_rows.h; a bur: cut/cut_rows.h) and is entered in Energies
/// (solve/energies.h).
struct Energy {
  YieldingRows yielding{};
  // At the solver's result:
  int pushing = 0;            ///< number of rows that push
  Vec6 force = Vec6::Zero();  ///< the sum of their forces, on [v; rho phi] [m]
};

}  // namespace palpate
