#pragma once

#include <cstddef>
#include <cstdint>

#include "scenes/scene.h"

namespace palpate {

/// Changes with every change of what comes out, so that cached scenes are built anew.
inline constexpr std::uint32_t kMeshOrientVersion = 3;

/// Turns triangles until neighbours wind alike, as most of their area did before, and each closed
/// piece encloses a positive volume.  A piece inside an odd number of others may be a cavity, and
/// stays as the rest of the mesh has it.  Neighbours share an edge of exactly two triangles;
/// patches that share none with the rest, as in a soup, and open shells are turned by winding
/// numbers (Jacobson et al., SIGGRAPH 2013).  What cannot be made to agree (a Moebius strip) is
/// left as it comes out.  Returns how many were turned.
std::size_t OrientTriangles(TriangleMesh& mesh);

}  // namespace palpate
