#pragma once

#include "scenes/scene.h"
#include "scenes/sphere_tree.h"

namespace palpate {

struct Spread {
  double mean = 0.0, p99 = 0.0, max = 0.0;
};

/// How well a sphere tree stands for its mesh [m].
struct Coverage {
  Spread outside;    ///< of each leaf: how far it sticks out of the solid
  Spread uncovered;  ///< of points all over the surface: distance to the nearest leaf
};

/// Set-up only.  Deterministic.
/// @param samples  points of the surface.
Coverage MeasureCoverage(const TriangleMesh& mesh, const SphereTree& tree,
                         std::size_t samples = 100000);

}  // namespace palpate
