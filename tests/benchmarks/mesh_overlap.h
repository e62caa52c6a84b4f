#pragma once

#include <memory>
#include <vector>

#include "common/math/pose.h"
#include "scenes/mesh_query.h"
#include "scenes/scene.h"

namespace palpate::bench {

/// How deep a tool's mesh is in the objects' meshes, or they in it, at any pose: the depth of the
/// deepest vertex of either inside the other, by the signed distance to the true surface.  One
/// measure for every contact model and every library, which shares nothing with any of them.
///
/// Exact over the vertices: balls round groups of vertices are passed over where the distance at
/// their centre, which no shift of d changes by more than d, leaves no room for a deeper one.
/// Two edges that cross without a vertex of either inside the other are not seen.
class MeshOverlap {
 public:
  /// The meshes must outlive this.
  MeshOverlap(const TriangleMesh& tool, const std::vector<Body>& objects);

  /// @returns the greatest depth [m]; 0 where no vertex is inside.
  double At(const Pose& X_WT) const;

 private:
  /// A mesh's vertices in a binary tree of balls; node i has the children 2i+1 and 2i+2, which have
  /// one half each of its vertices.
  struct VertexTree {
    explicit VertexTree(const TriangleMesh& mesh);
    struct Ball {
      Vec3 center;
      double radius;
    };
    std::vector<Ball> balls;
    std::vector<Vec3> vertices;  ///< in the tree's order
    std::size_t leaves = 1;      ///< of the tree, a power of two
  };
  struct Object {
    VertexTree vertices;
    MeshQuery query;
    Pose X_WB;
  };
  /// Raises `depth` to that of the deepest vertex, X being the pose of the vertices' frame in that
  /// of `in`.
  static void Deepen(const VertexTree& tree, const Pose& X, const MeshQuery& in, double& depth);

  VertexTree tool_;
  MeshQuery tool_query_;
  std::vector<std::unique_ptr<Object>> objects_;
};

}  // namespace palpate::bench
