#pragma once

#include "scenes/scene.h"

namespace palpate {

/// Turns triangles until neighbours wind alike, as most of their area did before, and a closed mesh
/// encloses a positive volume.  Neighbours share an edge of exactly two triangles.  What cannot be
/// made to agree (a Moebius strip) is left as it comes out.  Returns how many were turned.
std::size_t OrientTriangles(TriangleMesh& mesh);

}  // namespace palpate
