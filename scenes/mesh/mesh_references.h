#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/json/json_file.h"

namespace palpate {

/// A second file that holds a part of a mesh's geometry: a glTF buffer.
struct MeshReference {
  std::string uri;   ///< as the mesh names it
  std::string file;  ///< its path
};

/// The second files that a mesh needs, in the order in which it names them: only glTF has any, and
/// only its buffers count.  Pictures, materials and what the other formats name is never opened.
/// @param text  of the whole file.
/// Throws Error where the mesh is damaged, or a reference leads out of the mesh's folder.
std::vector<MeshReference> FindMeshReferences(const std::string& file, std::string_view text);

/// The one of a glTF's buffer; nothing where its data stand in the mesh's own file.
std::optional<MeshReference> ReferenceOf(const std::string& file, const JsonNode& buffer);

}  // namespace palpate
