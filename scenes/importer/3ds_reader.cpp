#include <algorithm>
#include <cstdint>
#include <cstring>
#include <new>
#include <string>
#include <vector>

#include <assimp/BaseImporter.h>
#include <assimp/Importer.hpp>
#include <assimp/config.h>
#include <assimp/importerdesc.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include "common/error.h"
#include "scenes/importer/mesh_text.h"
#include "scenes/importer/readers.h"

namespace palpate {
namespace {

/// Checks that a 3DS is one chunk, of type 0x4d4d and of the length that it gives.
void CheckLength(std::string_view bytes) {
  constexpr std::size_t kHeader = 6;
  if (bytes.size() < kHeader || !bytes.starts_with("MM")) {
    throw Error(std::string("it is not 3DS") + kExportAgain);
  }
  std::uint32_t declared = 0;
  std::memcpy(&declared, bytes.data() + 2, sizeof declared);
  if (declared > bytes.size()) {
    throw Error("it declares " + std::to_string(declared) + " bytes, and " +
                std::to_string(bytes.size()) +
                " are present; the file is truncated or damaged: export or copy it again");
  }
}

/// Names the parts: each has the name of its mesh and that of its node.
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

/// Unregisters all importers but that of 3DS: assimp would otherwise try them all on a file that
/// this one rejects.
void KeepOnlyImporter(Assimp::Importer& importer) {
  std::vector<Assimp::BaseImporter*> others;
  for (std::size_t i = 0; i < importer.GetImporterCount(); ++i) {
    if (std::strcmp(importer.GetImporterInfo(i)->mName, "Discreet 3DS Importer") != 0) {
      others.push_back(importer.GetImporter(i));
    }
  }
  for (Assimp::BaseImporter* other : others) {
    importer.UnregisterLoader(other);
    delete other;
  }
  if (importer.GetImporterCount() != 1) {
    throw Error("the installed assimp does not read 3DS; convert the mesh to another format");
  }
}

ImportedMesh MeshOf(const aiScene& scene) {
  ImportedMesh read;
  std::vector<std::uint32_t> begin;  // first triangle of each part
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& part = *scene.mMeshes[m];
    const auto offset = static_cast<std::uint32_t>(read.mesh.vertices.size());
    begin.push_back(static_cast<std::uint32_t>(read.mesh.triangles.size()));
    for (unsigned v = 0; v < part.mNumVertices; ++v) {
      read.mesh.vertices.emplace_back(part.mVertices[v].x, part.mVertices[v].y,
                                      part.mVertices[v].z);
    }
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      if (face.mNumIndices != 3) continue;
      const unsigned* const corner = face.mIndices;
      if (std::max({corner[0], corner[1], corner[2]}) >= part.mNumVertices) {
        throw Error("a face names a vertex that does not exist; export the mesh again");
      }
      read.mesh.triangles.push_back({offset + corner[0], offset + corner[1], offset + corner[2]});
    }
  }
  begin.push_back(static_cast<std::uint32_t>(read.mesh.triangles.size()));
  NameParts(scene, *scene.mRootNode, begin, read.groups);
  return read;
}

}  // namespace

FileContents Read3ds(const std::string&, std::string_view text) {
  CheckLength(text);
  Assimp::Importer importer;
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE,
                              aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  // otherwise parts lose their names
  importer.SetPropertyBool(AI_CONFIG_PP_PTV_KEEP_HIERARCHY, true);
  KeepOnlyImporter(importer);
  const aiScene* scene = importer.ReadFileFromMemory(
      text.data(), text.size(),
      aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_PreTransformVertices, "3ds");
  const std::string why = scene == nullptr              ? importer.GetErrorString()
                          : scene->mRootNode == nullptr ? "it holds no scene"
                                                        : "";
  // assimp catches some of these exceptions and reports their text.
  if (why == std::bad_alloc().what()) throw std::bad_alloc();
  if (!why.empty()) throw Error("cannot be read (" + why + ")" + kExportAgain);
  FileContents file{MeshOf(*scene)};
  file.step = kSingleStep * FarthestOf(file.read.mesh);
  return file;
}

}  // namespace palpate
