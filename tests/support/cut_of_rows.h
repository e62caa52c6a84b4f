#pragma once

#include <algorithm>

#include "server/physics/cut/cut_rows.h"

namespace palpate::test {

/// What a step cuts according to a bur's rows.
struct CutOfRows {
  double volume = 0.0;  ///< sum of A_i delta_i [m^3]
  double work = 0.0;    ///< of the solver's forces on the material, over k_t [m^2]

  CutOfRows(const CutRows& rows, const double* x, int unknowns) {
    for (int i = 0; i < rows.count(); ++i) {
      double along = 0.0;
      for (int c = 0; c < unknowns; ++c) along += rows.a(static_cast<std::size_t>(c))[i] * x[c];
      volume += rows.area()[i] * std::max(0.0, rows.b()[i] - along);
      work -= rows.forces()[i] * along;
    }
  }
};

}  // namespace palpate::test
