#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "scenes/progress.h"
#include "scenes/scene.h"
#include "scenes/sphere_tree.h"
#include "scenes/tree/leaf_count.h"
#include "scenes/tree/sphere.h"
#include "scenes/tree/tree_mode.h"

namespace palpate {

/// Changes with every change of what the builder makes, so that older cached scenes are built anew.
inline constexpr std::uint32_t kSphereTreeBuilderVersion = 4;

/// Sphere tree of exactly `leaves` leaves over a mesh (chapter 2.2.3); TreeMode::kOctree may have a
/// few less.
/// `mesh` may be open or not manifold, but must be oriented (mesh_orient.h).
/// Deterministic: equal inputs, equal bits.  One thread; 22,332 leaves of the bunny take seconds.
/// Throws Error where InspectMesh refuses the mesh or leaves is 0.
SphereTree BuildSphereTree(const TriangleMesh& mesh, std::size_t leaves,
                           const Progress& progress = {}, TreeMode mode = TreeMode::kInside);

/// The same for a body of which nothing but the mesh is felt: up to kInnerLeaves of the largest
/// balls that it holds, a picture of its inside.  Takes a few hundredths of the time.
SphereTree BuildInnerTree(const TriangleMesh& mesh);
inline constexpr std::size_t kInnerLeaves = 32;

/// The same of as many leaves as a tolerance needs (leaf_count.h): the tree that BuildSphereTree
/// makes of their count.
struct TolerantTree {
  SphereTree tree;
  LeafCount chosen;
  std::string found;      ///< for people: ToText of what was chosen
  std::string shortfall;  ///< for people: the tolerance was not reached, and what to do; or empty
};
/// Errors are measured at 10,007 points of the solid that the mesh stands for (mesh_solid.h).
TolerantTree BuildToTolerance(const TriangleMesh& mesh, const LeafTolerance& tolerance,
                              const Progress& progress = {}, TreeMode mode = TreeMode::kInside);

/// Tree whose leaves are balls that come from elsewhere, in any order [m].  The mesh's triangles
/// are shared out among them as BuildSphereTree does.
/// `balls`: at least one, finite, each with a radius above 0.
SphereTree TreeOverBalls(const TriangleMesh& mesh, const std::vector<Sphere>& balls);

/// Tree of one leaf that is exactly `ball`: a spherical tool.
SphereTree SingleSphereTree(const TriangleMesh& mesh, const Sphere& ball);

}  // namespace palpate
