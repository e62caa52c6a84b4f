#include "scenes/mesh/mesh_format.h"

#include <algorithm>
#include <array>
#include <filesystem>

#include "common/lower_case.h"

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

bool IsPackedMesh(const std::string& file) {
  return std::filesystem::path(file).extension() == ".gz";
}

}  // namespace palpate
