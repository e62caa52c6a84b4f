#pragma once

#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "common/math/pose.h"
#include "scenes/mesh/triangle.h"
#include "scenes/scene.h"

namespace palpate {

/// Point of triangle abc nearest to p (Ericson, Real-Time Collision Detection, 5.1.5); also right
/// for triangles that are degenerate to a segment or a point.
Vec3 NearestOnTriangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// Nearest point and inside test against a mesh, by a tree of boxes.  Set-up only: not real-time.
/// Lengths are in the mesh's unit.  The mesh must outlive the query, and its numbers be finite.
class MeshQuery {
 public:
  explicit MeshQuery(const TriangleMesh& mesh);

  struct Hit {
    Vec3 point = Vec3::Zero();
    double distance = std::numeric_limits<double>::infinity();
    std::uint32_t triangle = kNone;
  };
  static constexpr std::uint32_t kNone = 0xffffffffu;

  /// Nearest point of the surface that is nearer than `within`; triangle is kNone where there is
  /// none.
  Hit Nearest(const Vec3& p, double within = std::numeric_limits<double>::infinity()) const;
  /// How often the surface winds round p: 1 inside and 0 outside a closed mesh, between them near
  /// the holes of an open one (Jacobson et al., SIGGRAPH 2013; far triangles as dipoles after
  /// Barill et al., SIGGRAPH 2018, first order, within about 0.03).
  double WindingNumber(const Vec3& p) const;
  bool Inside(const Vec3& p) const { return WindingNumber(p) > 0.5; }

  /// Unit normal of a triangle, by its winding; zero where the triangle is degenerate.
  Vec3 FaceNormal(std::uint32_t triangle) const;
  /// Unit normal interpolated from the vertices' (angle weights would need acos; area weights do
  /// here), at a point of the triangle.
  Vec3 SmoothNormal(std::uint32_t triangle, const Vec3& point) const;

 private:
  struct Node {
    Vec3 min, max;
    std::int32_t child = -1;  ///< of an inner node the first of two; < 0 in leaves
    std::uint32_t begin = 0, end = 0;
    // Dipole: sum of area * normal [m^2] at the area's centroid, and the reach of the triangles.
    Vec3 dipole, centre;
    double reach = 0.0;
  };
  struct Facet;
  using Along = std::pair<double, std::uint32_t>;  // where a triangle lies along an axis
  void Build(std::int32_t node, const std::vector<Facet>& facets, std::vector<Along>& along);

  const TriangleMesh& mesh_;
  std::vector<Node> nodes_;
  std::vector<std::uint32_t> order_;  ///< triangle of each entry of corners_
  std::vector<Triangle> corners_;
  std::vector<Vec3> vertex_normals_;
};

}  // namespace palpate
