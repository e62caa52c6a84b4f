#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "scenes/scene.h"
#include "tests/support/random.h"

namespace palpate::test {

inline constexpr std::array<std::string_view, 4> kCurvedKinds{"sphere", "ellipsoid", "cylinder",
                                                              "torus"};

/// A smooth body, and its mesh with all corners on its surface.
class CurvedBody {
 public:
  struct Point {
    Vec3 at, normal;  ///< on the surface; unit, outward
  };

  /// @param kind  one of the above.  A sphere's and an ellipsoid's triangles are an icosahedron's,
  /// divided, a cylinder's (along z; with lids) and a torus's (round z) those of a grid.
  /// @param triangles  about so many: 0.8 to 2.1 times.
  CurvedBody(std::string_view kind, std::size_t triangles, Random& random);

  const TriangleMesh& mesh() const { return mesh_; }
  /// Returns the point of the surface, of a cylinder of its side, nearest to one that is near it.
  Point Nearest(const Vec3& p) const;
  /// Returns some point of the surface: far from a cylinder's lids; of a torus any, or one near its
  /// outer equator, with a direction in which it stays there.
  Point Start(bool convex, Vec3& along, Random& random) const;

  double greatest_curvature() const { return greatest_; }  ///< of any section [1/m]
  double least_curvature() const { return least_; }        ///< negative if it is hollow
  /// The most that the mesh and the surface are apart [m].  Over a triangle the distance is, but
  /// for the third order, a quadratic function that is 0 at the corners.  If it is e_i in the
  /// middles of the edges, it is 4 (e_1 l_2 l_3 + e_2 l_3 l_1 + e_3 l_1 l_2), at most 4/3 of the
  /// greatest e_i.
  double sagitta() const { return sagitta_; }
  /// The largest angle of a triangle to the surface below it [rad].  The gradient of that function
  /// is linear, so that its greatest is at a corner.
  double facet_angle() const { return facet_angle_; }
  double longest_edge() const { return longest_edge_; }  ///< without lids [m]

 private:
  enum class Kind { kSphere, kEllipsoid, kCylinder, kTorus };
  void Measure();

  Kind kind_;
  Vec3 size_ = Vec3::Zero();  ///< semi-axes; radius and half length; radii of ring and tube
  TriangleMesh mesh_;
  double greatest_ = 0.0, least_ = 0.0, sagitta_ = 0.0, facet_angle_ = 0.0, longest_edge_ = 0.0;
};

}  // namespace palpate::test
