#pragma once

#include <vector>

#include "scenes/sphere_tree.h"
#include "scenes/tree/sphere.h"

namespace palpate {

struct SphereHierarchy {
  SphereTree tree;                   ///< without triangles and centroid
  std::vector<std::uint32_t> order;  ///< leaf i of the tree is leaves[order[i]] of the input
};

/// Arranges leaves under packets of eight.  All packets are full, except the last of each level.
/// The ball of a node is the smallest round its leaves, rounded up to float.
SphereHierarchy ArrangeLeaves(const std::vector<Sphere>& leaves);

}  // namespace palpate
