#pragma once

#include <cstddef>
#include <vector>

#include "scenes/mesh/mesh_packet.h"
#include "scenes/scene.h"

namespace palpate {

/// Removes triangles; vertices stay, used or not.
/// @param kept    for each triangle, whether it stays.
/// @param groups  if given, its ranges are adjusted to mean the same triangles.
void KeepTriangles(const std::vector<bool>& kept, TriangleMesh& mesh,
                   std::vector<MeshGroup>* groups = nullptr);

/// Removes all but the first of the triangles that have the same three corners, in either winding,
/// as written by converters that store each face from both sides.  Both stay if a sheet would be
/// left: two faces back to back have no thickness, and it is unknown which was meant.  Returns how
/// many were removed.
std::size_t LeaveOutRepeatedTriangles(TriangleMesh& mesh, std::vector<MeshGroup>* groups = nullptr);

/// Small pieces that are apart from all larger ones, and together have hardly any of the surface.
struct Crumbs {
  std::size_t left_out = 0;  ///< number of pieces removed
  std::size_t kept = 0;      ///< number of pieces kept, which are closed
  double largest = 0.0;  ///< diagonal of the largest one's box, removed or kept [the mesh's unit]
};

/// Removes crumbs that are open, as a scanner sees them in the air.  A closed crumb is removed only
/// if it is tiny, because somebody may have modelled pearls or dots.  A mesh that consists only of
/// small pieces (a soup) is left as it is.
Crumbs LeaveOutCrumbs(TriangleMesh& mesh, std::vector<MeshGroup>* groups = nullptr);

}  // namespace palpate
