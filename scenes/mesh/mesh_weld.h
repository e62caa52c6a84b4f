#pragma once

#include <cstddef>

#include "scenes/scene.h"

namespace palpate {

/// What WeldOpenEdges did.
struct Welding {
  std::size_t vertices = 0;  ///< that became others
  double tolerance = 0.0;    ///< within which they lay [the mesh's unit]
};

/// Joins triangles whose corners lie beside each other and should be one, as where every facet
/// brought its own and a converter rounded them.  Only ends of open edges are moved, to the first
/// of those within a hundred-thousandth of the bounding box's diagonal, or a twentieth of the
/// median edge where that is less: finer detail than the one nobody feels, and the other keeps a
/// triangle from becoming a line.  Where it does not lessen the open edges, the mesh stays as it
/// was.
/// @param mesh  finite, with indices in range; exact copies of vertices are one already.
Welding WeldOpenEdges(TriangleMesh& mesh);

}  // namespace palpate
