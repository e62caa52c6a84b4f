#pragma once

#include "scenes/scene.h"

namespace palpate {

/// Returns the mesh with fewer triangles: large ones in flat parts, the old ones at creases.
/// Collapses edges onto one of their ends, cheapest first, as long as that end lies within about
/// `tolerance` [the mesh's unit] of the surface that it then represents (quadric error: Garland
/// & Heckbert, "Surface simplification using quadric error metrics", SIGGRAPH 1997).  The
/// remaining vertices do not move.  No collapse flips a triangle, makes it a needle, or makes
/// the mesh open or non-manifold.
/// @param mesh  closed and manifold.
TriangleMesh Simplified(const TriangleMesh& mesh, double tolerance);

}  // namespace palpate
