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

/// Computes whether a tool's mesh and the objects' meshes penetrate each other at a pose, and how
/// deep. It is the reference for all contact models and libraries: it takes triangles and poses,
/// and shares no code with the physics or with the mesh queries of scenes.
///
/// Exactness: the tool's corners are transformed into an object's frame in doubles (with a relative
/// rounding error of some 1e-16).  For these triangles `meet` is exact, even if meshes are open,
/// folded, non-manifold or degenerate; triangles are two-sided.
///
/// The depth is the greatest of
///  - the shortest translation that separates a pair (ShortestSeparation), over all pairs of
///  triangles that meet: a lower bound on how far the tool must move, at most of the order of the
///  triangles' size;
///  - for a closed mesh, the distance to its surface, over the other mesh's vertices inside of it.
///  This also detects a mesh that is wholly inside, where no triangles meet.
/// For open meshes only the first applies.  Soft bodies count as rigid.
///
/// A tool that is a ball in the physics is a ball here, too: it meets any triangle nearer than its
/// radius, by the radius minus the exact distance, or plus it inside a closed mesh.
class MeshOracle {
 public:
  struct PlacedMesh {
    const TriangleMesh* mesh;
    Pose X_WB{};
    std::uint32_t moved = 0;  ///< as Body::moved
  };
  struct ToolBall {
    Vec3 center;  ///< in the tool's frame [m]
    double radius;
  };
  /// The meshes need not outlive this.  A mesh without triangles meets nothing.
  MeshOracle(const TriangleMesh& tool, std::span<const PlacedMesh> objects);
  MeshOracle(const ToolBall& tool, std::span<const PlacedMesh> objects);
  /// For a scene's first tool, a ball if it has a single leaf, and all its objects.
  explicit MeshOracle(const Scene& scene);
  ~MeshOracle();
  MeshOracle(MeshOracle&&) noexcept;

  /// Puts the objects where their groups have moved them (MovedGroup).
  void Move(std::span<const Pose> groups);

  struct Overlap {
    bool meet = false;   ///< they share a point (a touch counts), or one is inside the other
    double depth = 0.0;  ///< [m]
    long pairs = 0;      ///< of triangles that meet; for a ball, triangles that it meets
  };
  Overlap At(const Pose& X_WT) const;
  /// Returns Overlap::meet alone; stops at the first pair.
  bool Meet(const Pose& X_WT) const;

  /// The nearest points of tool and objects, in W; for a ball, those of its surface.  A distance of
  /// 0, without points, if they meet.  Computed in doubles.
  struct Gap {
    double distance;  ///< infinite if there is no triangle
    Vec3 on_tool, on_object;
  };
  Gap Distance(const Pose& X_WT) const;

 private:
  struct Mesh;
  struct Object;
  Overlap Find(const Pose& X_WT, bool first_only) const;
  void FindMesh(const Object& object, const Pose& X_WT, bool first_only, Overlap& overlap) const;
  void FindBall(const Object& object, const Pose& X_WT, bool first_only, Overlap& overlap) const;

  std::unique_ptr<const Mesh> tool_;  ///< null if the tool is a ball
  ToolBall ball_{Vec3::Zero(), 0.0};
  std::vector<Object> objects_;
};

}  // namespace palpate::test
