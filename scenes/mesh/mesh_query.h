#pragma once

#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "common/math/pose.h"
#include "scenes/mesh/triangle.h"
#include "scenes/scene.h"

namespace palpate {

/// Returns the point of triangle abc nearest to p (Ericson, Real-Time Collision Detection, 5.1.5);
/// also for triangles that are degenerate to a segment or a point.
Vec3 NearestOnTriangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// Nearest-point and inside queries against a mesh, by a tree of boxes.  Set-up only: not
/// real-time.  Lengths are in the mesh's unit.  The mesh must outlive the query and be finite.
class MeshQuery {
 public:
  explicit MeshQuery(const TriangleMesh& mesh);

  struct Hit {
    Vec3 point = Vec3::Zero();
    double distance = std::numeric_limits<double>::infinity();
    std::uint32_t triangle = kNone;
  };
  static constexpr std::uint32_t kNone = 0xffffffffu;

  /// Returns the nearest point of the surface, if it is nearer than `within`; else
  /// triangle is kNone.
  Hit Nearest(const Vec3& p, double within = std::numeric_limits<double>::infinity()) const;
  /// Returns the winding number of the surface about p: 1 inside and 0 outside a closed mesh,
  /// between them near the holes of an open one (Jacobson et al., SIGGRAPH 2013; far triangles as
  /// dipoles after Barill et al., SIGGRAPH 2018, first order, within about 0.03).
  double WindingNumber(const Vec3& p) const;
  bool Inside(const Vec3& p) const { return WindingNumber(p) > 0.5; }

  /// Returns the unit normal of a triangle, by its winding; zero if it is degenerate.
  Vec3 FaceNormal(std::uint32_t triangle) const;
  /// Returns the unit normal at a point of the triangle, interpolated from the normals of the
  /// vertices, which are weighted by area (weights by angle would need acos).
  Vec3 SmoothNormal(std::uint32_t triangle, const Vec3& point) const;

 private:
  struct Node {
    Vec3 min, max;
    std::int32_t child = -1;  ///< of an inner node, the first of its two children; < 0 in leaves
    std::uint32_t begin = 0, end = 0;
    // Dipole: sum of area * normal [m^2] at the area's centroid, and the reach of the triangles.
    Vec3 dipole, centre;
    double reach = 0.0;
  };
  struct Facet;
  // position of a triangle along an axis, and its index
  using Along = std::pair<double, std::uint32_t>;
  void Build(std::int32_t node, const std::vector<Facet>& facets, std::vector<Along>& along);

  const TriangleMesh& mesh_;
  std::vector<Node> nodes_;
  std::vector<std::uint32_t> order_;  ///< triangle index of each entry of corners_
  std::vector<Triangle> corners_;
  std::vector<Vec3> vertex_normals_;
};

}  // namespace palpate
