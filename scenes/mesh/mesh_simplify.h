#pragma once

#include "scenes/scene.h"

namespace palpate {

/// The mesh with fewer triangles: flat parts get large ones, creases keep theirs.  Edges are
/// collapsed onto one of their ends, cheapest first, as long as the end lies within about
/// `tolerance` [the mesh's unit] of the surface that it then stands for (quadric error: Garland &
/// Heckbert, "Surface simplification using quadric error metrics", SIGGRAPH 1997).  The vertices
/// that are left stay where they were.  No collapse turns a triangle over, makes a needle of it, or
/// makes a closed manifold anything else.
/// @param mesh  closed and manifold.
TriangleMesh Simplified(const TriangleMesh& mesh, double tolerance);

}  // namespace palpate
