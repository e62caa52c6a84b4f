#pragma once

#include <array>

#include "common/math/pose.h"

namespace palpate::test {

/// The corners [m], in either winding.  A triangle may degenerate to a segment or a point.
using Triangle = std::array<Vec3, 3>;

/// Returns whether two closed triangles have a common point.  Exact (exact_orientation.h), also for
/// touching, coplanar and degenerate triangles.
bool Meet(const Triangle& a, const Triangle& b);

/// The penetration depth of two triangles that meet: the length of the shortest translation that
/// separates them.
///
///      |  a                 The shortest way out of a convex body is along a normal of a facet of
///   ___|___ b               the Minkowski difference: a face's normal, or the cross product of an
///      |} depth             edge of each.  So it is the least overlap of the two over these axes.
///
/// 0 if they only touch or are coplanar.  In doubles, to some 1e-16 of the coordinates.
struct Separation {
  double depth = 0.0;        ///< [m]
  Vec3 axis = Vec3::Zero();  ///< unit; b moves along it by `depth`.  Zero: any direction
};
Separation ShortestSeparation(const Triangle& a, const Triangle& b);

/// The nearest points of two triangles that do not meet, computed in doubles.
struct Nearest {
  double distance;
  Vec3 on_a, on_b;
};
Nearest NearestPoints(const Triangle& a, const Triangle& b);

/// Returns the point of a triangle nearest to p; the triangle may be degenerate.
Vec3 NearestPoint(const Triangle& triangle, const Vec3& p);

}  // namespace palpate::test
