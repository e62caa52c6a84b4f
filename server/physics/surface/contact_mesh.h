#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "common/math/pose.h"
#include "scenes/scene.h"

namespace palpate {

/// Allocates room for `count` elements in each of some vectors.
template <class... Vectors>
void ReserveEach(std::size_t count, Vectors&... vectors) {
  (vectors.reserve(count), ...);
}

/// The triangles that decide a body's contact, with the features that can touch (faces, edges and
/// vertices) and, for each feature, the cone of normals along which it can touch.  The mesh is used
/// as it is and touched from both sides; open, folded and non-manifold meshes need no special case.
///
/// The normal cone of an edge or vertex is the set of unit directions n, pointing away from the
/// mesh, from which it can be the nearest place of the mesh, because no path along the mesh leads
/// nearer (drawings in ../contact/README.md).
///
/// Frame F: the body's own; for a tool, about its reference point.
class ContactMesh {
 public:
  /// Corners in the order of the source; edge c leads from corner c to corner c + 1.
  struct Triangle {
    std::array<std::uint32_t, 3> vertex;
    std::array<std::uint32_t, 3> edge;
    Vec3 normal;  ///< unit; zero for a triangle without area
  };

  /// Scratch memory for Assign, which may be reused.
  struct Scratch;

  ContactMesh() = default;
  /// `origin`: of F, in the mesh's coordinates.  Triangles keep their numbers.
  explicit ContactMesh(const TriangleMesh& mesh, const Vec3& origin = Vec3::Zero());
  /// Returns a mesh of a single point at the origin: the centre of a spherical tool.
  static ContactMesh Point();
  /// Allocates storage for this many triangles, and as many vertices.
  void Reserve(std::size_t triangles);
  /// Rebuilds the mesh from triangles whose vertices all differ.  Real-time
  /// if the storage suffices.
  void Assign(std::span<const Vec3> vertices,
              std::span<const std::array<std::uint32_t, 3>> triangles, Scratch& scratch);

  /// Keeps the normals of SmoothNormal, which otherwise are computed anew in each call.
  void KeepNormals();

  const std::vector<Vec3>& vertices() const { return vertices_; }
  const std::vector<Triangle>& triangles() const { return triangles_; }
  bool empty() const { return triangles_.empty(); }
  const Vec3& Corner(std::size_t triangle, int corner) const {
    return vertices_[triangles_[triangle].vertex[static_cast<std::size_t>(corner)]];
  }

  /// Returns whether n, a unit direction in F away from the mesh, lies in the normal cone of
  /// an edge or vertex.
  bool EdgeConeHolds(std::uint32_t edge, const Vec3& n) const;
  bool VertexConeHolds(std::uint32_t vertex, const Vec3& n) const;
  /// The triangles at an edge, and at a vertex.
  std::span<const std::uint32_t> FacesAtEdge(std::uint32_t edge) const {
    return {edge_faces_.data() + edge_begin_[edge], edge_faces_.data() + edge_begin_[edge + 1]};
  }
  std::span<const std::uint32_t> FacesAtVertex(std::uint32_t vertex) const {
    return {vertex_faces_.data() + vertex_begin_[vertex],
            vertex_faces_.data() + vertex_begin_[vertex + 1]};
  }
  /// Returns the unit normal, at a point of a triangle, of the smooth surface that the triangles
  /// approximate.  n is the direction of the touch there; it is returned unchanged if the mesh has
  /// a crease there or is flat.
  Vec3 SmoothNormal(std::uint32_t triangle, const Vec3& place, const Vec3& n) const;
  /// Distance of the farthest vertex from the origin of F [m].
  double reach() const { return reach_; }

 private:
  void Weld(const TriangleMesh& mesh, const Vec3& origin);
  void AddTriangle(const std::array<std::uint32_t, 3>& vertex);
  void Connect(Scratch& scratch);
  std::uint32_t Across(std::uint32_t triangle, std::uint32_t corner) const;
  std::array<Eigen::Vector3f, 3> CornerNormals(std::uint32_t triangle) const;

  std::vector<Vec3> vertices_;
  std::vector<Triangle> triangles_;
  std::vector<std::uint32_t> edge_begin_{0}, edge_faces_;
  std::vector<std::uint32_t> vertex_begin_{0}, vertex_faces_;
  /// For each corner of each triangle, the smooth normal, or the triangle's own where the surface
  /// has a crease.  Empty unless kept.
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
