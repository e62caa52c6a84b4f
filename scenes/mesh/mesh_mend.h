#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scenes/mesh/mesh_packet.h"
#include "scenes/scene.h"

namespace palpate {

/// Repairs a mesh as it was read, for use as a body: welds it (mesh_weld.h), removes repeated
/// triangles and crumbs (mesh_crumbs.h), and orients it (mesh_orient.h).  A clean mesh stays the
/// same, bit for bit.
/// @param mesh    not refused by InspectMesh.
/// @param groups  if given, the mesh's named parts, which are adjusted to mean the same triangles.
/// Returns what was done, for people: a sentence each, with the remedy.  Defects that remain, such
/// as holes, are reported by InspectMesh.
std::vector<std::string> MendMesh(TriangleMesh& mesh, std::vector<MeshGroup>* groups = nullptr);

}  // namespace palpate
