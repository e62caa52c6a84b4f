#pragma once

#include <string>
#include <string_view>

#include "scenes/mesh/mesh_packet.h"

namespace palpate {

/// Reads a mesh file in this process.  A damaged file may use up memory and time, or crash
/// assimp, so only palpate-import calls this, after it has limited itself; others call
/// ImportMesh.  Vertices at the same place become one.  Throws Error with the file's name, the
/// reason and a remedy.
ImportedMesh ReadMeshFile(const std::string& file);

/// Reads the mesh from a file's bytes, unpacked.
/// @param file  for its name, its format and the place of its buffers (mesh_references.h).
ImportedMesh ReadMeshText(const std::string& file, std::string_view text);

}  // namespace palpate
