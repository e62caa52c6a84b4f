#pragma once

#include <cmath>
#include <cstdint>

#include "common/math/pose.h"
#include "server/physics/simd/kernels.h"

namespace palpate {

/// A feature of a triangle: corner 0 to 2, edge 0 to 2 (from corner i to the next), or its face.
struct Feature {
  enum Kind : std::uint8_t { kVertex, kEdge, kFace };
  Kind kind = kVertex;
  std::uint8_t index = 0;
};

/// The nearest points of two triangles.
/// @field p, q     nearest points of the first and the second [m]
/// @field of_p     the feature of the first triangle on which p lies (not at an end of an edge, nor
///                 on the border of a face); likewise of_q
/// @field squared  |p - q|^2 [m^2]
struct NearestPoints {
  Vec3 p, q;
  Feature of_p, of_q;
  double squared;
  double Distance() const { return std::sqrt(squared); }
  /// Returns the unit direction from q to p; the points must differ.
  Vec3 Direction() const { return (p - q) / Distance(); }
};

/// Returns the nearest points of two triangles that do not intersect, given by their corners;
/// triangles may be degenerate (edges or points).  For triangles that intersect, returns some pair
/// of points: the caller must check whether the plane across them separates the two.
/// Vertices against faces, and edges against edges (Ericson, Real-Time Collision Detection, 5.1).
/// Real-time.  Deterministic.
NearestPoints NearestOfTriangles(const Vec3 a[3], const Vec3 b[3],
                                 const Kernels& kernels = ActiveKernels()) noexcept;

}  // namespace palpate
