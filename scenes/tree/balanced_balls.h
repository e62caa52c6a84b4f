#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "scenes/mesh/mesh_query.h"
#include "scenes/mesh/surface_samples.h"
#include "scenes/tree/inner_balls.h"
#include "scenes/tree/sphere.h"

namespace palpate {

/// The input of BalanceBalls.  All must outlive the call.
struct BallsToBalance {
  const MeshQuery& query;
  const InnerBalls& inner;  ///< makes balls where others are moved to
  /// Centres of the probe as it rolls over the surface, evenly spread (ScatterAbove); some
  /// twenty per ball.
  const std::vector<SurfaceSample>& samples;
  double probe;    ///< radius of the probe: the samples' height [m]
  double spacing;  ///< of neighbouring balls [m]
};

/// Moves and resizes balls that touch a surface from inside, to minimise the error of the force
/// that a hand feels when it touches their union with a small ball, the probe.
///
///        o  probe, at p, which would touch the surface at the foot of its normal n
///     ___|_______  surface
///     (  |  )(    )     union of the balls c_i, r_i
///
/// At p the union lies h = |p - c| - r - probe below the surface, where c and r are the ball
/// nearest to p, and pushes along u = (p - c)/|p - c|.  A hand that presses `depth` deep into
/// something stiff and slides has an error of h along the normal, relative to that depth, and of
/// the angle between u and n, in radians.  So the relative force error is e = (h/depth, |u - n|).
/// Minimised is the mean over all p of |e|^2 / (1 + |e|^2/0.3^2), which keeps a crease where no
/// ball is right from attracting all balls.  The depth is 15 % of the spacing.  No ball sticks out
/// of the surface by more than 1/40 of the spacing, or grows beyond ten spacings.
///
/// Errors are measured with a probe, not at points of the surface, because then each place counts
/// in proportion to how much can touch it, rims and tips more than hollows; and because what
/// touches is never sharper than the leaves of its own tree.
///
/// Set-up only.  Deterministic.
/// @param done  is told the share of the work done, 0 to 1.
void BalanceBalls(const BallsToBalance& work, std::vector<Sphere>& balls,
                  const std::function<void(double)>& done);

}  // namespace palpate
