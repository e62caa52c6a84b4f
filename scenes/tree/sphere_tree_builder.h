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

/// Builds a sphere tree of exactly `leaves` leaves over a mesh (chapter 2.2.3).
/// `mesh` may be open or not manifold, but must be oriented (mesh_orient.h).
/// Deterministic: equal inputs, equal bits.  One thread; 22,332 leaves of the bunny take seconds.
/// Throws Error if InspectMesh refuses the mesh or `leaves` is 0.
SphereTree BuildSphereTree(const TriangleMesh& mesh, std::size_t leaves,
                           const Progress& progress = {}, TreeMode mode = TreeMode::kInside);

/// Builds a tree for a body that is felt by its mesh alone: up to kInnerLeaves of the largest balls
/// inside it, a rough model of its interior.  Takes a few hundredths of the time.
SphereTree BuildInnerTree(const TriangleMesh& mesh);
inline constexpr std::size_t kInnerLeaves = 32;

/// The tree that BuildSphereTree makes with as many leaves as a tolerance needs (leaf_count.h).
struct TolerantTree {
  SphereTree tree;
  LeafCount chosen;
  std::string found;  ///< for people: ToText of `chosen`
  /// for people: why the tolerance was not reached, and what to do; or empty
  std::string shortfall;
};
/// Builds such a tree.  Measures errors at 10,007 points of the solid that the
/// mesh represents (mesh_solid.h).
TolerantTree BuildToTolerance(const TriangleMesh& mesh, const LeafTolerance& tolerance,
                              const Progress& progress = {}, TreeMode mode = TreeMode::kInside);

/// Builds a tree over given leaves, in any order [m].  The mesh's triangles are distributed among
/// them as BuildSphereTree does.
/// `balls`: at least one, finite, each with a radius above 0.
SphereTree TreeOverBalls(const TriangleMesh& mesh, const std::vector<Sphere>& balls);

/// Builds a tree with one leaf that is exactly `ball`: a spherical tool.
SphereTree SingleSphereTree(const TriangleMesh& mesh, const Sphere& ball);

}  // namespace palpate
