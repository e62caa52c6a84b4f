#pragma once

#include "common/math/pose.h"

namespace palpate::test {

// Signs of determinants of points, exact for all finite doubles whose products neither overflow nor
// underflow (coordinates from 1e-60 to 1e60).  Doubles first, with Shewchuk's bound on their
// rounding; within that bound, expansions: sums of doubles that stand for one exact number
// (Shewchuk, Discrete Comput. Geom. 18 (1997) 305-363).

/// @returns 1 where d lies on the side of plane abc from which abc is seen clockwise (behind its
/// normal), -1 on the other side, 0 in the plane, or where abc spans none.
int Orient3d(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// Of the points' projections along `axis` (0: x, 1: y, 2: z).
/// @returns 1 where abc turns counter-clockwise, seen from the end of the axis; 0 on one line.
int Orient2d(const Vec3& a, const Vec3& b, const Vec3& c, int axis);

}  // namespace palpate::test
