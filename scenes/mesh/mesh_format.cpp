#include "scenes/mesh/mesh_format.h"

#include <algorithm>
#include <array>
#include <filesystem>

#include "common/error.h"
#include "common/text/lower_case.h"

namespace palpate {

std::string MeshFormatOf(const std::string& file) {
  std::filesystem::path path(file);
  if (IsPackedMesh(file)) path.replace_extension();
  const std::string extension = LowerCase(path.extension().string());
  return extension.empty() ? extension : extension.substr(1);
}

bool IsMeshFile(const std::string& file) {
  static constexpr std::array kKnown{"obj", "stl", "ply", "3ds", "gltf", "glb"};
  return std::find(kKnown.begin(), kKnown.end(), MeshFormatOf(file)) != kKnown.end();
}

std::string KnownMeshFormatOf(const std::string& file) {
  const std::string format = MeshFormatOf(file);
  if (IsMeshFile(file)) return format;
  throw Error(file + (format.empty()
                          ? ": its name has no extension to tell its format; add .obj, .stl, .ply, "
                            ".3ds, .gltf or .glb"
                          : ": the format \"" + format +
                                "\" is not known; convert it to OBJ, STL, PLY, 3DS or glTF"));
}

bool IsPackedMesh(const std::string& file) {
  return std::filesystem::path(file).extension() == ".gz";
}

}  // namespace palpate
