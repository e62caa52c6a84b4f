#pragma once

#include <array>

#include "common/math/pose.h"

namespace palpate::test {

/// Corners [m].  May be a needle, a segment or a point; either winding.
using Triangle = std::array<Vec3, 3>;

/// Whether two closed triangles have a point in common: exact (exact_orientation.h), for crossing,
/// touching, coplanar and degenerate ones alike.
bool Meet(const Triangle& a, const Triangle& b);

/// How deep two triangles that meet are in each other: the length of the shortest translation that
/// takes them apart.
///
///      |  a                 The shortest way out of a convex body is along a normal of a facet of
///   ___|___ b               the Minkowski difference: a face's normal, or the cross product of an
///      |} depth             edge of each.  So it is the least overlap of the two over these axes.
///
/// 0 where one merely touches the other, and in one plane.  In doubles: right to some 1e-16 of the
/// coordinates.
struct Separation {
  double depth = 0.0;        ///< [m]
  Vec3 axis = Vec3::Zero();  ///< unit; b moves along it by `depth`.  Zero where any way will do
};
Separation ShortestSeparation(const Triangle& a, const Triangle& b);

/// Nearest points of two triangles that do not meet, in doubles.
struct Nearest {
  double distance;
  Vec3 on_a, on_b;
};
Nearest NearestPoints(const Triangle& a, const Triangle& b);

/// Nearest point of a triangle; also of a degenerate one.
Vec3 NearestPoint(const Triangle& triangle, const Vec3& p);

}  // namespace palpate::test
