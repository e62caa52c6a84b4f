#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/math/pose.h"
#include "scenes/scene.h"
#include "tests/support/triangle_overlap.h"

namespace palpate::test {

/// Whether a tool's mesh and the objects' meshes are in each other at a pose, and how deep.  The
/// judge of every contact model and every library: it takes triangles and poses, and shares no code
/// with the physics, nor with what scenes use to query meshes.
///
/// What is exact: the tool's corners are taken into an object's frame in doubles (rounded by some
/// 1e-16 of their coordinates); of these triangles `meet` is exact, for meshes that are open,
/// folded, non-manifold or degenerate, and triangles count from both sides.
///
/// What depth means: the greatest of
///  - over all pairs of triangles that meet, the shortest translation that takes the two apart
///    (ShortestSeparation): a lower bound of how far the tool must move, of the order of the
///    triangles' size at most;
///  - where a mesh is closed, over the other one's vertices inside of it, the distance to its
///    surface.  It sees also what is wholly inside, where no triangles meet.
/// So of open meshes only the first counts.  Soft bodies count as rigid ones.
///
/// A tool that the physics takes for a ball is one here: it meets a triangle that is nearer than
/// its radius, and the depth is the radius less the exact distance, or plus it where its centre is
/// inside a closed mesh.
class MeshOracle {
 public:
  struct PlacedMesh {
    const TriangleMesh* mesh;
    Pose X_WB{};
  };
  struct ToolBall {
    Vec3 center;  ///< in the tool's frame [m]
    double radius;
  };
  /// Nothing of the meshes is kept.  A mesh without triangles meets nothing.
  MeshOracle(const TriangleMesh& tool, std::span<const PlacedMesh> objects);
  MeshOracle(const ToolBall& tool, std::span<const PlacedMesh> objects);
  /// Of a scene's first tool, a ball where it has one leaf, and all its objects.
  explicit MeshOracle(const Scene& scene);
  ~MeshOracle();
  MeshOracle(MeshOracle&&) noexcept;

  struct Overlap {
    bool meet = false;   ///< a point in common, be it a touch; or one inside the closed other
    double depth = 0.0;  ///< [m]
    long pairs = 0;      ///< of triangles that meet; of a ball, triangles
  };
  Overlap At(const Pose& X_WT) const;
  /// Overlap::meet alone, which is known with the first pair.
  bool Meet(const Pose& X_WT) const;

  /// Nearest points of tool and objects, in W; a distance of 0, without points, where Meet().  Of a
  /// ball, of its surface.  In doubles.
  struct Gap {
    double distance;  ///< infinite where there is no triangle
    Vec3 on_tool, on_object;
  };
  Gap Distance(const Pose& X_WT) const;

 private:
  struct Mesh;
  struct Object;
  Overlap Find(const Pose& X_WT, bool first_only) const;
  void FindMesh(const Object& object, const Pose& X_WT, bool first_only, Overlap& overlap) const;
  void FindBall(const Object& object, const Pose& X_WT, bool first_only, Overlap& overlap) const;

  std::unique_ptr<const Mesh> tool_;  ///< null where the tool is a ball
  ToolBall ball_{Vec3::Zero(), 0.0};
  std::vector<Object> objects_;
};

}  // namespace palpate::test
