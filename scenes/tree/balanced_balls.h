#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "scenes/mesh/mesh_query.h"
#include "scenes/mesh/surface_samples.h"
#include "scenes/tree/inner_balls.h"
#include "scenes/tree/sphere.h"

namespace palpate {

/// What BalanceBalls works on.  All must outlive the call.
struct BallsToBalance {
  const MeshQuery& query;
  const InnerBalls& inner;  ///< makes balls where others are moved to
  /// Points all over the surface, evenly; some twenty a ball.
  const std::vector<SurfaceSample>& samples;
  double spacing;  ///< of neighbouring balls [m]
};

/// Moves and resizes balls that touch a surface from inside until their union errs as little as
/// they can in the force that a hand feels on it.  A hand that presses `depth` deep into something
/// stiff and slides is off by the union's offset from the surface along the normal, as a share of
/// that depth, and by the tilt of the union's normal, in radians: the relative force error is
/// e = (offset/depth, tilt), and what is minimised is the mean over the surface of
/// |e|^2 / (1 + |e|^2/0.3^2), so that an edge, where no ball is right, does not draw all balls.
/// The depth is 15 % of the spacing.  A ball sticks out of the surface nowhere by more than
/// 1/40 of the spacing, and stays as large at most as ten spacings.
/// Set-up only.  Deterministic.
/// @param done  told the share of the work, 0 to 1.
void BalanceBalls(const BallsToBalance& work, std::vector<Sphere>& balls,
                  const std::function<void(double)>& done);

}  // namespace palpate
