#pragma once

#include <string>
#include <string_view>

namespace palpate {

/// The most bytes of a mesh file, unpacked: a larger one is a mistake or an attack.
inline constexpr std::size_t kLargestMeshFile = std::size_t{2} << 30;

/// Returns a file's format by its name alone: "ply" for "dragon.PLY.gz".
std::string MeshFormatOf(const std::string& file);

/// Returns whether the name ends as a mesh file's does.
bool IsMeshFile(const std::string& file);

/// Returns the format of a mesh file.  Throws Error, with the remedy, if the name is not
/// that of one.
std::string KnownMeshFormatOf(const std::string& file);

/// Returns true for "dragon.ply.gz".
bool IsPackedMesh(const std::string& file);

}  // namespace palpate
