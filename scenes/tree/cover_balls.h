#pragma once

#include <functional>
#include <vector>

#include "scenes/mesh/mesh_query.h"
#include "scenes/scene.h"
#include "scenes/tree/inner_balls.h"
#include "scenes/tree/sphere.h"

namespace palpate {

/// The input of CoverWithBalls.  All must outlive the call.
struct SurfaceToCover {
  const TriangleMesh& mesh;
  const MeshQuery& query;
  const InnerBalls& inner;  ///< makes balls where others are moved to
  double spacing;           ///< of neighbouring balls [m]
};

/// Moves and resizes balls, which lie inside a surface, until they contain all of it and stick out
/// of it as little as possible.
///
/// The surface is cut into bits, each a triangle or part of one.  Each bit is assigned to a ball
/// that contains its three corners, and so all of it: this certifies that nothing is uncovered.  A
/// ball with centre c sticks out by max |x - c| - d(c), where x are the corners of its bits and d
/// is the distance to the surface.  So a bit goes best to the ball, among those with radii d(c),
/// that is nearest to it, and a ball's centre best to where that difference is least.  Both steps
/// alternate (Lloyd, IEEE Trans. Inf. Theory 28 (1982) 129-137, for this measure); balls that are
/// not needed move to where others stick out most.
///
/// Set-up only.  Deterministic.
/// @param done  is told the share of the work done, 0 to 1.
void CoverWithBalls(const SurfaceToCover& work, std::vector<Sphere>& balls,
                    const std::function<void(double)>& done);

}  // namespace palpate
