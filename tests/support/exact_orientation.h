#pragma once

#include "common/math/pose.h"

namespace palpate::test {

// Signs of orientation determinants of points, exact for all finite doubles whose products neither
// overflow nor underflow (coordinates from 1e-60 to 1e60).  They are computed in doubles first; if
// the result is within Shewchuk's bound on the rounding error, with expansions, which are sums of
// doubles that represent one exact number (Shewchuk, Discrete Comput. Geom. 18 (1997) 305-363).

/// @returns 1 if d lies on the side of plane abc from which abc is seen clockwise (behind its
/// normal), -1 on the other side, 0 if d lies in the plane or abc spans none.
int Orient3d(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d);

/// Orientation of the points' projections along `axis` (0: x, 1: y, 2: z), seen from its end.
/// @returns 1 if abc runs counter-clockwise, -1 if clockwise, 0 if collinear.
int Orient2d(const Vec3& a, const Vec3& b, const Vec3& c, int axis);

}  // namespace palpate::test
