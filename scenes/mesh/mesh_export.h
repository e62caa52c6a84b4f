#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/scene.h"

namespace palpate {

struct MeshExportOptions {
  double metres_per_unit = 1.0;  ///< the unit of the file
  std::string comment;           ///< one line, for people
  /// For each triangle 0xrrggbb, which only a PLY holds; empty: none.
  std::vector<std::uint32_t> colours{};
};

/// The endings of what ExportMesh writes.
inline constexpr std::string_view kExportedMeshes = ".stl, .obj or .ply";

/// Returns the bytes of a mesh file in the format of the file's ending: a binary STL, of single
/// precision, or an OBJ or a binary PLY, of double; palpate-import keeps single precision of all.
/// In a PLY with colours each vertex has that of one of its faces, too, for programs that read only
/// those.
/// Throws Error for another ending, a vertex that is not finite, and a triangle of no vertex.
std::string ExportMesh(const TriangleMesh& mesh, const std::string& file,
                       const MeshExportOptions& options);

}  // namespace palpate
