#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/json/json_file.h"

namespace palpate {

/// A second file that holds part of a mesh's geometry: a glTF buffer.
struct MeshReference {
  std::string uri;   ///< as the mesh names it
  std::string file;  ///< its path
};

/// Returns the second files that a mesh needs, in the order in which it names them: only glTF
/// has any, and only its buffers count.  Pictures, materials and references in other formats
/// are never opened.
/// @param text  the contents of the mesh file.
/// Throws Error if the mesh is damaged, or a reference leads out of the mesh's folder.
std::vector<MeshReference> FindMeshReferences(const std::string& file, std::string_view text);

/// Returns the file of a glTF's buffer; nothing if the data are in the mesh's own file.
std::optional<MeshReference> ReferenceOf(const std::string& file, const JsonNode& buffer);

}  // namespace palpate
