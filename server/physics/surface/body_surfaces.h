#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/math/pose.h"
#include "server/physics/leaf_pair.h"
#include "server/physics/step_types.h"
#include "server/physics/surface/contact_surface.h"
#include "server/physics/tree/sphere_tree_query.h"

namespace palpate {

/// True where an object's surface decides its contact: it is rigid and stays.  What yields or is
/// scraped off has its compliance and hardness by leaf, so its leaves decide.
bool HasSurface(const PlacedTree& object);

/// The surfaces of all objects of a scene that have one, in W.  Immutable.
class ObjectSurfaces {
 public:
  /// Throws Error where such an object has no mesh.
  explicit ObjectSurfaces(std::span<const PlacedTree> objects);

  std::vector<SurfacePoint> points;
  std::vector<SurfacePatch> patches;
  std::vector<PatchDisc> discs;
  std::vector<CreaseSegment> creases;
  std::vector<std::uint32_t> patch_object;  ///< index of the object that each belongs to
  /// Leaf of the forest that each belongs to.
  std::vector<std::uint32_t> point_leaf, patch_leaf, crease_leaf;
  /// Leaf i is entry i; null where there are none.
  std::unique_ptr<const ObjectForest> point_forest, patch_forest, crease_forest;

  /// Leaf of the sphere trees' forest that the object side of a row between surfaces belongs to.
  std::uint32_t LeafOf(NodePair pair) const;
};

/// The surface of a tool, about its reference point; of a spherical tool its centre, as a point
/// with a radius.  Immutable.
class ToolSurface {
 public:
  /// `mesh` may be null for a spherical tool, whose tree has one leaf.
  ToolSurface(const TriangleMesh* mesh, const SphereTree& tree, const Vec3& reference,
              double world_extent);

  std::vector<SurfacePoint> points;
  std::vector<SurfacePatch> patches;
  std::vector<PatchDisc> discs;
  std::vector<CreaseSegment> creases;
  double radius = 0.0;     ///< of a spherical tool [m]; 0 for others
  double max_lever = 0.0;  ///< of any point [m]; 0 for a spherical tool
  std::unique_ptr<const ToolTree> point_tree, patch_tree, crease_tree;
};

}  // namespace palpate
