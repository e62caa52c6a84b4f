#include "common/coupling_fault.h"

#include <cstdio>

namespace palpate {

std::string CouplingFault(double stiffness, double torsional_stiffness, double reach) {
  constexpr double kMostRho = 1000.0;
  const double least = stiffness * (reach / kMostRho) * (reach / kMostRho);
  if (torsional_stiffness >= least) return "";
  char text[256];
  std::snprintf(text, sizeof text,
                "%g N m/rad is too low for a stiffness of %g N/m, with a tool that extends %g mm "
                "from its centroid; give at least %.3g, or a lower stiffness",
                torsional_stiffness, stiffness, 1e3 * reach, 1.01 * least);
  return text;
}

}  // namespace palpate
