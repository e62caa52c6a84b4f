#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "common/math/pose.h"
#include "scenes/scene.h"

namespace palpate {

/// A mesh whose smooth parts are curved: every triangle has a unit normal at each corner, and
/// stands for the patch
///   P(b) = p - 1/2 sum_i b_i ((p - p_i) . n_i) n_i,   p = sum_i b_i p_i,
/// with the normal sum_i b_i n_i.  That is the parabola through two points with given tangents, on
/// every line across it (a Nagata patch, Comput. Aided Geom. Des. 22 (2005) 327-347, without its
/// special cases): exact to second order, flat where the normals are the triangle's own, and the
/// same from both sides of a smooth edge.  Frame and unit [m] are the mesh's.
struct SurfaceMesh {
  struct Triangle {
    std::array<std::uint32_t, 3> vertex;
    std::array<Vec3, 3> normal;  ///< outward, of each corner
    std::uint32_t source;        ///< triangle of the mesh that it is a part of
  };
  /// An edge where the surface has a crease, or ends.
  struct SharpEdge {
    std::array<std::uint32_t, 2> vertex;
    std::array<std::uint32_t, 2> triangle;  ///< twice the same where the surface ends
    bool convex;                            ///< also where the surface ends
  };
  std::vector<Vec3> vertices;
  std::vector<Triangle> triangles;
  std::vector<SharpEdge> sharp_edges;

  /// Unit normal of the flat triangle.
  Vec3 FaceNormal(std::size_t triangle) const;
};

/// Angle between two triangles above which their common edge is a crease: 40 degrees.
inline constexpr double kCreaseCosine = 0.766;

/// @param mesh          oriented; triangles without area are left out, and pairs back to back.
/// @param longest_edge  [m]: longer edges are halved, on the curved surface, until none is left.
/// Set-up only.  Deterministic.
SurfaceMesh MakeSurfaceMesh(const TriangleMesh& mesh, double longest_edge);

}  // namespace palpate
