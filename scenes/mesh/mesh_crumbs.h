#pragma once

#include <cstddef>
#include <vector>

#include "scenes/mesh/mesh_packet.h"
#include "scenes/scene.h"

namespace palpate {

/// Leaves out triangles; vertices stay where they are, in use or not.
/// @param kept    of each triangle.
/// @param groups  where given, its ranges go on meaning the same triangles.
void KeepTriangles(const std::vector<bool>& kept, TriangleMesh& mesh,
                   std::vector<MeshGroup>* groups = nullptr);

/// Of triangles with the same three corners, whichever way they wind, leaves the first, as where a
/// converter wrote each face from both sides.  What would be a sheet without the second face stays
/// as it came: two faces back to back have no thickness, and nobody knows which one was meant.
/// Returns how many were left out.
std::size_t LeaveOutRepeatedTriangles(TriangleMesh& mesh, std::vector<MeshGroup>* groups = nullptr);

/// Pieces that are small, float apart from all that is not, and together are hardly any of the
/// surface.
struct Crumbs {
  std::size_t left_out = 0;  ///< pieces
  std::size_t kept = 0;      ///< closed ones
  double largest = 0.0;      ///< of either kind: its box's diagonal [the mesh's unit]
};

/// Leaves out what a scanner sees in the air: crumbs that are open.  A closed one is left out only
/// where it is dust, for pearls and dots may be what somebody modelled.  A soup, which consists of
/// small pieces, stays.
Crumbs LeaveOutCrumbs(TriangleMesh& mesh, std::vector<MeshGroup>* groups = nullptr);

}  // namespace palpate
