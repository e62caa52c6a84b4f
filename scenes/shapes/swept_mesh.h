#pragma once

#include <array>
#include <vector>

#include "common/math/pose.h"
#include "scenes/scene.h"

namespace palpate {

/// Solid rod along a curve: rings of `sides` vertices round the curve's points, of the radius given
/// for each point, and a point at each end.  Round ends are radii that go to 0 with the points.
/// Closed, manifold, oriented; a bend must be wider than the rod.
/// @param curve  [m], at least two points, all different.   @param radii  > 0 [m], one a point.
TriangleMesh MakeRod(const std::vector<Vec3>& curve, const std::vector<double>& radii, int sides);

/// What a curve (rho, y) sweeps that turns round the axis y, closed by a disc at its first and its
/// last point.  Outside lies to the right of the curve, rho being to the right and y up.
/// @param curve  [m], rho > 0, at least two points, none the next one's.
TriangleMesh MakeTurned(const std::vector<std::array<double, 2>>& curve, int sides);

/// Open pipe along a curve: an inner and an outer wall, joined by flat rings at both ends.
TriangleMesh MakePipe(const std::vector<Vec3>& curve, double inner_radius, double wall, int sides);

}  // namespace palpate
