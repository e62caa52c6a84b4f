#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/math/pose.h"
#include "scenes/sphere_packet.h"

namespace palpate {

/// Sphere tree of one mesh (chapter 2.2.3).  Every leaf lies at the same depth, and packets are
/// stored level by level; level 0 is one packet.  Immutable once built; plain data.
struct SphereTree {
  // Leaf i is the ball at (leaf_x, leaf_y, leaf_z)[i] of leaf_radius[i], in the tree frame [m].
  std::vector<double> leaf_x, leaf_y, leaf_z, leaf_radius;

  std::vector<SpherePacket> packets;
  /// levels + 1 entries; level l is packets[begin[l] .. begin[l+1]), and a child index counts from
  /// the beginning of the next level.
  std::vector<std::int32_t> level_begin;

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
