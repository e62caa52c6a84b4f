#pragma once

#include <array>
#include <vector>

#include "common/math/pose.h"
#include "scenes/scene.h"

namespace palpate {

/// Makes a solid rod along a curve: a ring of `sides` vertices round each point of the curve, with
/// the radius given for that point, and a vertex at each end.  For round ends, let the radii go to
/// 0 with the points.  Closed, manifold, oriented; a bend must be wider than the rod.
/// @param curve  [m], at least two points, all different.   @param radii  > 0 [m], one per point.
TriangleMesh MakeRod(const std::vector<Vec3>& curve, const std::vector<double>& radii, int sides);

/// Makes the solid that a curve (rho, y) sweeps when it turns round the y axis, closed by a disc at
/// its first and its last point.  The outside is to the right of the curve, with rho to the right
/// and y up.
/// @param curve  [m], rho > 0, at least two points, each different from the next.
TriangleMesh MakeTurned(const std::vector<std::array<double, 2>>& curve, int sides);

/// Makes an open pipe along a curve: an inner and an outer wall, joined by flat rings at both ends.
TriangleMesh MakePipe(const std::vector<Vec3>& curve, double inner_radius, double wall, int sides);

}  // namespace palpate
