#pragma once

#include <string>
#include <string_view>

namespace palpate {

/// The most that a mesh file may hold, unpacked: more is no mesh, but a mistake or an attack.
inline constexpr std::size_t kLargestMeshFile = std::size_t{2} << 30;

/// "ply" for "dragon.PLY.gz": by the name alone.
std::string MeshFormatOf(const std::string& file);

/// True where the name ends as a mesh file's does.
bool IsMeshFile(const std::string& file);

/// The same where it is a mesh file's.  Throws Error with the remedy where it is none.
std::string KnownMeshFormatOf(const std::string& file);

/// True for "dragon.ply.gz".
bool IsPackedMesh(const std::string& file);

}  // namespace palpate
