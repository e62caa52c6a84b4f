#pragma once

#include <string>
#include <string_view>

#include "scenes/mesh/mesh_packet.h"

namespace palpate {

/// Reads a mesh file in this process: a damaged one may take all memory and time, or crash assimp.
/// For palpate-import, which limits itself first; everybody else calls ImportMesh.
/// Vertices of the same place are one.  Throws Error with the file's name, the reason and a remedy.
ImportedMesh ReadMeshFile(const std::string& file);

/// The same of a file's bytes, unpacked.
/// @param file  names it, tells its format, and where its buffers are (mesh_references.h).
ImportedMesh ReadMeshText(const std::string& file, std::string_view text);

}  // namespace palpate
