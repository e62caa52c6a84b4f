#pragma once

#include <cstddef>
#include <cstdint>

#include "scenes/scene.h"

namespace palpate {

/// Turns triangles until neighbours wind alike, in the way of most of their area, and each closed
/// piece encloses a positive volume.  A piece inside an odd number of others may be a cavity, and
/// is wound as the rest of the mesh has it.  Neighbours are two triangles at an edge that has no
/// third.  Patches that share no such edge with the rest, as in a soup, and open shells are turned
/// by winding numbers (Jacobson et al., SIGGRAPH 2013).  What cannot be made consistent (a Moebius
/// strip) is left as it comes out.  Returns the number of triangles turned.
std::size_t OrientTriangles(TriangleMesh& mesh);

}  // namespace palpate
