#include "scenes/mesh_import.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <filesystem>
#include <memory>
#include <numeric>
#include <vector>

#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <zlib.h>

#include "common/error.h"
#include "scenes/json_file.h"
#include "scenes/mesh_report.h"

namespace palpate {
namespace {

constexpr std::size_t kLargestUnpacked = std::size_t{2} << 30;  // no mesh; a mistake or an attack

std::string Unpack(const std::string& file) {
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> gz(gzopen(file.c_str(), "rb"), gzclose);
  if (!gz) throw Error(file + ": cannot be opened; check the name and the rights");
  std::string text;
  std::array<char, 1 << 16> block;
  for (;;) {
    const int got = gzread(gz.get(), block.data(), block.size());
    int status = Z_OK;
    const char* why = gzerror(gz.get(), &status);
    if (got < 0 || (got == 0 && status != Z_OK && status != Z_STREAM_END)) {
      throw Error(file + ": is damaged (" + why + "); fetch it again");
    }
    if (got == 0) return text;
    text.append(block.data(), got);
    if (text.size() > kLargestUnpacked) {
      throw Error(file + ": unpacks to more than 2 GiB; simplify the mesh first");
    }
  }
}

/// "ply" for "dragon.PLY.gz".
std::string FormatOf(const std::string& file) {
  std::filesystem::path path(file);
  if (path.extension() == ".gz") path.replace_extension();
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension.empty() ? extension : extension.substr(1);
}

/// Vertices at the same place become one; the order of first use stays.
void Weld(TriangleMesh& mesh) {
  std::vector<std::uint32_t> order(mesh.vertices.size());
  std::iota(order.begin(), order.end(), 0u);
  const auto place = [&](std::uint32_t i) {
    const Vec3& v = mesh.vertices[i];
    std::array<std::uint64_t, 3> bits;  // bits, for NaN has a place in the order, too
    const Vec3 positive_zero = v + Vec3::Zero();
    std::memcpy(bits.data(), positive_zero.data(), sizeof bits);
    return bits;
  };
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    const auto pa = place(a);
    const auto pb = place(b);
    return pa < pb || (pa == pb && a < b);
  });
  std::vector<std::uint32_t> first(mesh.vertices.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool same = k > 0 && place(order[k]) == place(order[k - 1]);
    first[order[k]] = same ? first[order[k - 1]] : order[k];
  }
  std::vector<std::uint32_t> renamed(mesh.vertices.size());
  std::uint32_t kept = 0;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    if (first[v] != v) continue;
    renamed[v] = kept;
    mesh.vertices[kept++] = mesh.vertices[v];
  }
  mesh.vertices.resize(kept);
  for (auto& triangle : mesh.triangles) {
    for (std::uint32_t& v : triangle) v = renamed[first[v]];
  }
}

/// Formats differ in whether a part's name is its mesh's or its node's: both are taken.
/// @param begin  first triangle of each of the scene's meshes, and the end.
void NameParts(const aiScene& scene, const aiNode& node, const std::vector<std::uint32_t>& begin,
               std::vector<MeshGroup>& groups) {
  for (unsigned i = 0; i < node.mNumMeshes; ++i) {
    const unsigned m = node.mMeshes[i];
    const std::string of_node = node.mName.C_Str();
    const std::string of_mesh = scene.mMeshes[m]->mName.C_Str();
    if (!of_mesh.empty()) groups.push_back({of_mesh, begin[m], begin[m + 1]});
    if (!of_node.empty() && of_node != of_mesh) {
      groups.push_back({of_node, begin[m], begin[m + 1]});
    }
  }
  for (unsigned i = 0; i < node.mNumChildren; ++i) {
    NameParts(scene, *node.mChildren[i], begin, groups);
  }
}

}  // namespace

bool IsMeshFile(const std::string& file) {
  static constexpr std::array kKnown{"obj", "stl", "ply", "3ds", "gltf", "glb"};
  return std::find(kKnown.begin(), kKnown.end(), FormatOf(file)) != kKnown.end();
}

TriangleMesh ImportMesh(const std::string& file, std::vector<MeshGroup>* groups) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  if (!fs::exists(file, ignored)) throw Error(file + ": there is no such file; check the name");
  Assimp::Importer importer;
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE,
                              aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  importer.SetPropertyBool(AI_CONFIG_PP_PTV_KEEP_HIERARCHY, true);  // else parts lose their names
  const unsigned flags =
      aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_PreTransformVertices;
  const std::string format = FormatOf(file);
  if (!IsMeshFile(file)) {
    throw Error(file + ": the format \"" + format +
                "\" is not known; convert it to OBJ, STL, PLY, 3DS or glTF");
  }
  const aiScene* scene = nullptr;
  if (fs::path(file).extension() == ".gz") {
    const std::string text = Unpack(file);
    scene = importer.ReadFileFromMemory(text.data(), text.size(), flags, format.c_str());
  } else {
    ReadWholeFile(file);  // for its message, which says why; assimp's does not
    scene = importer.ReadFile(file, flags);
  }
  if (scene == nullptr) {
    throw Error(file + ": cannot be read (" + importer.GetErrorString() +
                "); the file is damaged or in another format than its name says, export it again");
  }
  TriangleMesh mesh;
  std::vector<std::uint32_t> begin;  // first triangle of each part
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& part = *scene->mMeshes[m];
    const auto offset = static_cast<std::uint32_t>(mesh.vertices.size());
    begin.push_back(static_cast<std::uint32_t>(mesh.triangles.size()));
    for (unsigned v = 0; v < part.mNumVertices; ++v) {
      mesh.vertices.emplace_back(part.mVertices[v].x, part.mVertices[v].y, part.mVertices[v].z);
    }
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      if (face.mNumIndices != 3) continue;
      mesh.triangles.push_back(
          {offset + face.mIndices[0], offset + face.mIndices[1], offset + face.mIndices[2]});
    }
  }
  begin.push_back(static_cast<std::uint32_t>(mesh.triangles.size()));
  if (groups != nullptr) NameParts(*scene, *scene->mRootNode, begin, *groups);
  Weld(mesh);
  return mesh;
}

void PlaceMesh(const MeshPlacement& placement, TriangleMesh& mesh) {
  const MeshReport report = InspectMesh(mesh);
  double scale = placement.metres_per_unit;
  if (placement.longest_side) {
    scale = *placement.longest_side / (report.box_max - report.box_min).maxCoeff();
  }
  Vec3 origin = Vec3::Zero();
  if (placement.origin == MeshPlacement::Origin::kBoxCentre) {
    origin = 0.5 * (report.box_min + report.box_max);
  } else if (placement.origin == MeshPlacement::Origin::kCentroid) {
    origin = report.centroid;
  }
  for (Vec3& v : mesh.vertices) v = scale * (v - origin);
}

}  // namespace palpate
