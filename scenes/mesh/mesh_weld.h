#pragma once

#include <cstddef>

#include "scenes/scene.h"

namespace palpate {

/// The result of WeldOpenEdges.
struct Welding {
  std::size_t vertices = 0;  ///< number of vertices that were merged into others
  double tolerance = 0.0;    ///< the distance up to which they were merged [the mesh's unit]
};

/// Joins triangles whose corners should be one vertex but differ slightly, as when each facet has
/// its own vertices and a converter rounded them.  Only ends of open edges are merged: into the
/// first of those within a hundred-thousandth of the bounding box's diagonal, or within a
/// twentieth of the median edge if that is less.  The former is finer than anybody feels; the
/// latter keeps triangles from becoming lines.  If this does not reduce the open edges, the mesh
/// stays as it was.
/// @param mesh  finite, with indices in range; exact copies of vertices are already merged.
Welding WeldOpenEdges(TriangleMesh& mesh);

}  // namespace palpate
