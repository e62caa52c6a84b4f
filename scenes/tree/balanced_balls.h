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
  /// Where the centre of the probe is as it rolls over the surface, evenly (ScatterAbove); some
  /// twenty a ball.
  const std::vector<SurfaceSample>& samples;
  double probe;    ///< radius of the ball that feels: the samples' height [m]
  double spacing;  ///< of neighbouring balls [m]
};

/// Moves and resizes balls that touch a surface from inside until their union errs as little as
/// they can in the force that a hand feels on it, through a small ball, the probe.
///
///        o  probe, at p, which would touch the surface at the foot of its normal n
///     ___|_______  surface
///     (  |  )(    )     union of the balls c_i, r_i
///
/// At p the union lies h = |p - c| - r - probe below the surface, c and r the ball nearest to p,
/// and pushes along u = (p - c)/|p - c|.  A hand that presses `depth` deep into something stiff and
/// slides is off by h along the normal, as a share of that depth, and by the tilt of u against n,
/// in radians: the relative force error is e = (h/depth, |u - n|), and what is minimised is the
/// mean over all p of |e|^2 / (1 + |e|^2/0.3^2), so that a crease where no ball is right does not
/// draw all balls.  The depth is 15 % of the spacing.  A ball sticks out of the surface nowhere by
/// more than 1/40 of the spacing, and stays as large at most as ten spacings.
///
/// Why a probe and no point: a place counts as much as something can touch it, rims and tips more
/// than hollows; and what touches is never sharper than the leaves of the tree that it is made of.
/// Set-up only.  Deterministic.
/// @param done  told the share of the work, 0 to 1.
void BalanceBalls(const BallsToBalance& work, std::vector<Sphere>& balls,
                  const std::function<void(double)>& done);

}  // namespace palpate
