#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scenes/mesh/mesh_packet.h"
#include "scenes/scene.h"

namespace palpate {

/// Changes with every change of what comes out, so that cached scenes are built anew.
inline constexpr std::uint32_t kMeshMendVersion = 2;

/// Makes of a mesh as it was read what a body is made of: welds (mesh_weld.h), leaves out repeated
/// triangles and crumbs (mesh_crumbs.h), and orients (mesh_orient.h).  A clean mesh stays as it is,
/// to the bit.
/// @param mesh    not refused by InspectMesh.
/// @param groups  where given, the mesh's named parts, which go on meaning the same triangles.
/// Returns what was done, for people: a sentence each, with the remedy.  What stays as it was,
/// holes say, InspectMesh tells of.
std::vector<std::string> MendMesh(TriangleMesh& mesh, std::vector<MeshGroup>* groups = nullptr);

}  // namespace palpate
