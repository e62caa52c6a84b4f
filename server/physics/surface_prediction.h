#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "server/physics/contact_rows.h"
#include "server/physics/contact_surface.h"
#include "server/physics/leaf_pair.h"
#include "server/physics/sphere_tree_query.h"

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

/// Rows between the true surfaces of tool and objects for one sub-step.  One per workspace.
class SurfacePrediction {
 public:
  SurfacePrediction(const ToolSurface& tool, const ObjectSurfaces& objects);

  /// Adds the rows for the graphic tool at R_WG with its reference point at p_W.
  /// Where `times` is given, adds to its prediction and rows stages.  Real-time.
  /// @param max_depth  what lies deeper below a surface than this is no concern of it [m];
  ///   infinite: also what lies inside and could not have come there
  /// @param recovery  what a row wants made good in full of what lies below [m]; of the rest a
  /// part.
  ///   A spherical tool's rows want all
  void Predict(const Kernels& kernels, const Mat3& R_WG, const Vec3& p_W, const StepBounds& bounds,
               double max_depth, double recovery, int degrees_of_freedom, double rho,
               ContactRows& rows, StageTimes* times) noexcept;

  /// Packet pairs tested so far, and pairs looked at for a row: either takes some 10 ns.
  std::int64_t tested() const;

 private:
  const ToolSurface& tool_;
  const ObjectSurfaces& objects_;
  std::vector<NodePair> near_;
  std::int64_t candidates_ = 0;
  std::optional<PairQuery> point_on_patch_, patch_on_point_, creases_;
};

}  // namespace palpate
