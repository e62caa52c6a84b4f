#pragma once

#include <functional>
#include <vector>

#include "scenes/mesh/mesh_query.h"
#include "scenes/scene.h"
#include "scenes/tree/inner_balls.h"
#include "scenes/tree/sphere.h"

namespace palpate {

/// What CoverWithBalls works on.  All must outlive the call.
struct SurfaceToCover {
  const TriangleMesh& mesh;
  const MeshQuery& query;
  const InnerBalls& inner;  ///< makes balls where others are moved to
  double spacing;           ///< of neighbouring balls [m]
};

/// Moves and resizes balls, which lie inside a surface, until they hold all of it and stick out of
/// it as little as they can.
///
/// The surface is cut into bits, each a triangle or part of one, and each bit has a ball that holds
/// its three corners, and so all of it: that is the certificate that nothing is uncovered.  A ball
/// with the centre c that holds some bits sticks out by max |x - c| - d(c), x their corners and d
/// the distance to the surface.  So a bit does least harm in the ball that is nearest to it of
/// those with the radii d(c), and the centre of a ball goes where that difference is least.  By
/// turns (Lloyd, IEEE Trans. Inf. Theory 28 (1982) 129-137, for this measure); balls that can be
/// spared go where others stick out most.
/// Set-up only.  Deterministic.
/// @param done  told the share of the work, 0 to 1.
void CoverWithBalls(const SurfaceToCover& work, std::vector<Sphere>& balls,
                    const std::function<void(double)>& done);

}  // namespace palpate
