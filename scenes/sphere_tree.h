#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/math/pose.h"
#include "scenes/sphere_packet.h"

namespace palpate {

/// Where the leaves of a tree come from, and how they stand for the mesh.  For people: nothing that
/// is felt asks for it.
enum class TreeOrigin : std::uint8_t {
  kUnknown,   ///< a scene that does not say: an older bundle, or one that has travelled
  kInside,    ///< built, as TreeMode's of the same names (tree_mode.h)
  kBalanced,  //
  kCover,     //
  kOctree,    //
  kFile,      ///< read from a .sph file
  kBall,      ///< one leaf that is exactly the ball which the mesh stands for
};

/// Sphere tree of one mesh (chapter 2.2.3).  Every leaf lies at the same depth, and packets are
/// stored level by level; level 0 is one packet.  Immutable once built; plain data.
/// The leaves are what may be felt.  The levels above are no coarser shapes of the body: each of
/// their balls bounds the leaves below it, for the contact prediction, and sticks out as far as
/// that takes.  A level of detail that is to be felt is a tree of its own, built with fewer leaves.
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
  TreeOrigin origin = TreeOrigin::kUnknown;

  std::size_t leaves() const { return leaf_radius.size(); }
  int levels() const { return static_cast<int>(level_begin.size()) - 1; }
  std::span<const SpherePacket> level(int l) const {
    return {packets.data() + level_begin[l], packets.data() + level_begin[l + 1]};
  }
};

}  // namespace palpate
