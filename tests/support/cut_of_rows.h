#pragma once

#include <algorithm>

#include "server/physics/cut/cut_rows.h"

namespace palpate::test {

/// What a step cuts according to a bur's rows.
struct CutOfRows {
  double volume = 0.0;  ///< sum of A_i delta_i [m^3]
  double work = 0.0;    ///< of the solver's forces on the material, over k_t [m^2]

  CutOfRows(const CutRows& rows, const double* x) {
    for (int i = 0; i < rows.count(); ++i) {
      double along = 0.0;
      for (std::size_t c = 0; c < 6; ++c) along += rows.yielding.rows.a[c][i] * x[c];
      volume += rows.area()[i] * std::max(0.0, rows.yielding.rows.b[i] - along);
      work -= rows.yielding.push[i] * along;
    }
  }
};

}  // namespace palpate::test
