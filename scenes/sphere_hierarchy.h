#pragma once

#include <vector>

#include "scenes/sphere.h"
#include "scenes/sphere_tree.h"

namespace palpate {

/// A leaf before it has its place in the tree.
struct LeafSphere {
  Sphere ball;
  Vec3 touch;  ///< where it touches the surface; leaves of one node should lie close in this, too
};

struct SphereHierarchy {
  SphereTree tree;                   ///< without triangles and centroid
  std::vector<std::uint32_t> order;  ///< leaf i of the tree is leaves[order[i]] of the input
};

/// Arranges leaves under packets of eight.  All packets are full but the last of each level; the
/// ball of a node is the smallest round its leaves, rounded up to float.
SphereHierarchy ArrangeLeaves(const std::vector<LeafSphere>& leaves);

}  // namespace palpate
