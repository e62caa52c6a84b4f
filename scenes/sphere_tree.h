#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/math/pose.h"

namespace palpate {

inline constexpr int kTreeArity = 8;

/// Eight sibling nodes as a structure of arrays: one SIMD register per coordinate.  Lanes without a
/// node hold NaN in every float, so that no comparison with them is ever true, and -1 as child.
struct alignas(32) SpherePacket {
  float x[kTreeArity];  ///< node centres, tree frame [m]
  float y[kTreeArity];
  float z[kTreeArity];
  float radius[kTreeArity];  ///< [m], rounded up: the node holds all *leaf spheres* below it
  std::int32_t
      child[kTreeArity];  ///< packet, counted within the next level; in the last level, leaf
};

/// Sphere tree of one mesh (chapter 2.2.3).  Every leaf lies at the same depth, and packets are
/// stored level by level; level 0 is one packet.  Immutable once built; plain data.
struct SphereTree {
  // Leaf i is the ball at (leaf_x, leaf_y, leaf_z)[i] of leaf_radius[i], in the tree frame [m].
  std::vector<double> leaf_x, leaf_y, leaf_z, leaf_radius;

  std::vector<SpherePacket> packets;
  std::vector<std::int32_t> level_begin;  ///< levels + 1 entries; level l is [begin[l], begin[l+1])

  // Triangles of the source mesh that leaf i stands for: leaf_triangle[leaf_triangle_begin[i] ..
  // leaf_triangle_begin[i+1]).  Every triangle belongs to at least one leaf.
  std::vector<std::uint32_t> leaf_triangle_begin, leaf_triangle;

  Vec3 centroid = Vec3::Zero();  ///< of the solid (of the surface where the mesh is open) [m]

  std::size_t leaves() const { return leaf_radius.size(); }
  int levels() const { return static_cast<int>(level_begin.size()) - 1; }
  std::span<const SpherePacket> level(int l) const {
    return {packets.data() + level_begin[l], packets.data() + level_begin[l + 1]};
  }
};

}  // namespace palpate
