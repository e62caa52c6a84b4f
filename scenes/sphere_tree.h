#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/math/pose.h"
#include "scenes/sphere_packet.h"

namespace palpate {

/// Where the leaves of a tree come from, and how they represent the mesh.  Information for people:
/// the physics does not use it.
enum class TreeOrigin : std::uint8_t {
  kUnknown,   ///< not stated: an older bundle, or a scene that was sent
  kInside,    ///< built in the TreeMode of the same name (tree_mode.h), as the next
  kBalanced,  //
  kCover,     ///< of an older bundle: leaves that contain the surface, no longer a mode
  kOctree,    ///< likewise: round the cells of an octree
  kFile,      ///< likewise: read from a file
  kBall,      ///< one leaf: exactly the ball that the mesh represents
};

/// The sphere tree of a mesh (chapter 2.2.3).  All leaves lie at the same depth.  Packets are
/// stored level by level; level 0 is one packet.  Immutable once built; plain data.
/// Only the leaves can be felt.  The balls of the levels above are no coarser shapes of the body:
/// each only bounds the leaves below it, for the contact prediction, and sticks out as far as that
/// needs.  To feel a coarser shape, build another tree with fewer leaves.
struct SphereTree {
  // Leaf i is the ball with centre (leaf_x, leaf_y, leaf_z)[i] and radius leaf_radius[i], in the
  // tree frame [m].
  std::vector<double> leaf_x, leaf_y, leaf_z, leaf_radius;

  std::vector<SpherePacket> packets;
  /// levels + 1 entries: level l is packets[begin[l] .. begin[l+1]).  A child index counts from the
  /// beginning of the next level.
  std::vector<std::int32_t> level_begin;

  // Triangles of the source mesh that leaf i represents: leaf_triangle[leaf_triangle_begin[i] ..
  // leaf_triangle_begin[i+1]).  Every triangle belongs to at least one leaf.
  std::vector<std::uint32_t> leaf_triangle_begin, leaf_triangle;

  Vec3 centroid = Vec3::Zero();  ///< of the solid; of the surface if the mesh is open [m]
  TreeOrigin origin = TreeOrigin::kUnknown;

  std::size_t leaves() const { return leaf_radius.size(); }
  int levels() const { return static_cast<int>(level_begin.size()) - 1; }
  std::span<const SpherePacket> level(int l) const {
    return {packets.data() + level_begin[l], packets.data() + level_begin[l + 1]};
  }
};

}  // namespace palpate
