#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/math/pose.h"
#include "scenes/scene.h"

namespace palpate {

/// The triangles that contact with a body is decided by, with the features that can touch: faces,
/// edges and vertices, and the cone of normals that each of them can touch along.  The mesh is
/// taken as it is, and felt from either side: open, folded and non-manifold ones need no special
/// case.
///
/// Normal cone of an edge or vertex: the unit directions n, away from the mesh, along which it can
/// be the nearest place of the mesh, for no way along the mesh leads nearer (../contact/README.md
/// draws them).
///
/// Frame F: W for objects, the tool's frame about its reference point for a tool.
class ContactMesh {
 public:
  /// Corners in the order of the source; edge c leads from corner c to corner c + 1.
  struct Triangle {
    std::array<std::uint32_t, 3> vertex;
    std::array<std::uint32_t, 3> edge;
    Vec3 normal;  ///< unit; zero for a triangle without area
  };

  /// What making one takes, which may be used again.
  struct Scratch;

  ContactMesh() = default;
  /// `X_FB` places the mesh into F.  Triangles are numbered as its own.
  ContactMesh(const TriangleMesh& mesh, const Pose& X_FB);
  /// A single point at the origin: the centre of a spherical tool.
  static ContactMesh Point();
  /// Storage for so many triangles, and as many vertices.
  void Reserve(std::size_t triangles);
  /// Makes the mesh anew, of triangles whose vertices all differ.  Real-time within the storage.
  void Assign(std::span<const Vec3> vertices,
              std::span<const std::array<std::uint32_t, 3>> triangles, const Pose& X_FB,
              Scratch& scratch);

  const std::vector<Vec3>& vertices() const { return vertices_; }
  const std::vector<Triangle>& triangles() const { return triangles_; }
  bool empty() const { return triangles_.empty(); }
  const Vec3& Corner(std::size_t triangle, int corner) const {
    return vertices_[triangles_[triangle].vertex[static_cast<std::size_t>(corner)]];
  }

  /// Whether n, a unit direction in F away from the mesh, lies in the cone of an edge or vertex.
  bool EdgeConeHolds(std::uint32_t edge, const Vec3& n) const;
  bool VertexConeHolds(std::uint32_t vertex, const Vec3& n) const;
  /// Triangles at an edge, at a vertex.
  std::span<const std::uint32_t> FacesAtEdge(std::uint32_t edge) const {
    return {edge_faces_.data() + edge_begin_[edge], edge_faces_.data() + edge_begin_[edge + 1]};
  }
  std::span<const std::uint32_t> FacesAtVertex(std::uint32_t vertex) const {
    return {vertex_faces_.data() + vertex_begin_[vertex],
            vertex_faces_.data() + vertex_begin_[vertex + 1]};
  }
  /// Unit normal of the smooth surface that the triangles approximate, at a place of a triangle
  /// near which n is the direction of a touch; n itself where the mesh has a crease or is flat
  /// there.
  Vec3 SmoothNormal(std::uint32_t triangle, const Vec3& place, const Vec3& n) const;
  /// Distance of the farthest vertex from the origin of F [m].
  double reach() const { return reach_; }

 private:
  void Weld(const TriangleMesh& mesh, const Pose& X_FB);
  void AddTriangle(const std::array<std::uint32_t, 3>& vertex);
  void Connect(Scratch& scratch);
  std::uint32_t Across(std::uint32_t triangle, std::uint32_t corner) const;
  std::array<Eigen::Vector3f, 3> CornerNormals(std::uint32_t triangle) const;

  std::vector<Vec3> vertices_;
  std::vector<Triangle> triangles_;
  std::vector<std::uint32_t> edge_begin_{0}, edge_faces_;
  std::vector<std::uint32_t> vertex_begin_{0}, vertex_faces_;
  /// Of each triangle's corners; that of the triangle where the surface has a crease.  None where
  /// the mesh was made anew: few of its triangles are asked about before it is again.
  std::vector<std::array<Eigen::Vector3f, 3>> normals_;
  double reach_ = 0.0;
};

struct ContactMesh::Scratch {
  void Reserve(std::size_t triangles);

  struct Side {
    std::uint32_t low, high, triangle, corner;
  };
  std::vector<Side> sides, sorted;
  std::vector<std::size_t> place;
  std::vector<std::uint32_t> faces;
};

}  // namespace palpate
