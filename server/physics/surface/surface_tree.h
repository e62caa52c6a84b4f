#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/math/pose.h"
#include "scenes/sphere_tree.h"

namespace palpate {

/// A piece of a surface: everything within `slack` of the hull of its corners.
struct SurfacePiece {
  std::array<Vec3, 3> corner;  ///< may repeat
  double slack = 0.0;
  std::uint32_t leaf = 0;  ///< of the sphere tree that it belongs to
};

/// The sphere tree of a body with pieces of its surface below the leaves, for the prediction of
/// surface contact; a node with more than eight children becomes several, as in a B-tree.  Every
/// ball holds the pieces below it, and stands out in front of them as little as can be: of several
/// pieces it has its centre inside the body where that is better than their own middle, of one it
/// lies round that.  Sorts `order`, which names the pieces, as the leaves of the new tree lie.  No
/// leaves, no packets: for an empty list.  Set-up only.  Deterministic.
/// @param X_FB  from the sphere tree's frame to the pieces'
SphereTree MakeSurfaceTree(const SphereTree& spheres, const Pose& X_FB,
                           const std::vector<SurfacePiece>& pieces,
                           std::vector<std::uint32_t>& order);

}  // namespace palpate
