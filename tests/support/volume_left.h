#pragma once

#include <numeric>

#include "scenes/grid/cut_field.h"

namespace palpate::test {

/// Returns the remaining volume of all materials [m^3].  Visits all points.
inline double TotalLeft(const CutField& cut) {
  const auto left = cut.VolumeLeft();
  return std::accumulate(left.begin(), left.end(), 0.0);
}

}  // namespace palpate::test
