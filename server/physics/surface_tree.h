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
  Vec3 outward = Vec3::Zero();  ///< unit normal; zero where it has none
  std::uint32_t leaf = 0;       ///< of the sphere tree that it belongs to
};

/// The sphere tree of a body with pieces of its surface below the leaves, for the prediction of
/// surface contact.  Every ball holds the pieces below it, and stands out in front of them as
/// little as can be: that of a node keeps its centre inside the body, that of a few pieces takes
/// its leaf's centre where that is better than their own middle. Sorts `order`, which names the
/// pieces, as the leaves of the new tree lie. No leaves, no packets: for an empty list.  Set-up
/// only.  Deterministic.
/// @param X_FB  from the sphere tree's frame to the pieces'
SphereTree MakeSurfaceTree(const SphereTree& spheres, const Pose& X_FB,
                           const std::vector<SurfacePiece>& pieces,
                           std::vector<std::uint32_t>& order);

}  // namespace palpate
