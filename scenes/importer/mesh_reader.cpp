#include "scenes/importer/mesh_reader.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <map>
#include <memory>
#include <new>
#include <numeric>
#include <utility>
#include <vector>

#include <assimp/BaseImporter.h>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <assimp/MemoryIOWrapper.h>
#include <assimp/config.h>
#include <assimp/importerdesc.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <spdlog/fmt/fmt.h>
#include <unistd.h>
#include <zlib.h>

#include "common/error.h"
#include "common/whole_file.h"
#include "scenes/importer/declared_size.h"
#include "scenes/importer/far_off.h"
#include "scenes/mesh/mesh_format.h"
#include "scenes/mesh/mesh_references.h"

namespace palpate {
namespace {

[[noreturn]] void RefuseLarge(const std::string& file) {
  throw Error(file + ": holds more than 2 GiB; simplify the mesh first");
}

std::string Unpack(const std::string& file) {
  const int fd = OpenRegularFile(file, kLargestMeshFile);
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> gz(gzdopen(fd, "rb"), gzclose);
  if (!gz) {
    close(fd);
    throw Error(file + ": cannot be unpacked; there is no memory left");
  }
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
    if (text.size() > kLargestMeshFile) RefuseLarge(file);
  }
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

/// The mesh and its buffers, and nothing else of the disk: what a mesh names besides, as pictures
/// and materials, is not there.
class OnlyTheseFiles : public Assimp::IOSystem {
 public:
  void Add(const std::string& name, std::string_view bytes) { files_[name] = bytes; }
  void Own(const std::string& name, std::string bytes) {
    owned_.push_back(std::make_unique<std::string>(std::move(bytes)));
    Add(name, *owned_.back());
  }

  bool Exists(const char* name) const override { return files_.contains(name); }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* name, const char*) override {
    const auto it = files_.find(name);
    if (it == files_.end()) return nullptr;
    return new Assimp::MemoryIOStream(reinterpret_cast<const std::uint8_t*>(it->second.data()),
                                      it->second.size());
  }
  void Close(Assimp::IOStream* stream) override { delete stream; }

 private:
  std::map<std::string, std::string_view, std::less<>> files_;
  std::vector<std::unique_ptr<std::string>> owned_;
};

/// Leaves the one importer of a format: assimp would try all that it has on a file that the one
/// declines.
void KeepOnlyImporterOf(const std::string& format, Assimp::Importer& importer) {
  static const std::map<std::string, std::string> kNames{
      {"obj", "Wavefront Object Importer"},
      {"stl", "Stereolithography (STL) Importer"},
      {"ply", "Stanford Polygon Library (PLY) Importer"},
      {"3ds", "Discreet 3DS Importer"},
      {"gltf", "glTF2 Importer"},
      {"glb", "glTF2 Importer"}};
  const std::string& wanted = kNames.at(format);
  std::vector<Assimp::BaseImporter*> others;
  for (std::size_t i = 0; i < importer.GetImporterCount(); ++i) {
    if (importer.GetImporterInfo(i)->mName != wanted) others.push_back(importer.GetImporter(i));
  }
  for (Assimp::BaseImporter* other : others) {
    importer.UnregisterLoader(other);
    delete other;
  }
  if (importer.GetImporterCount() != 1) {
    throw Error("this assimp does not read " + format + "; convert the mesh to another format");
  }
}

ImportedMesh MeshOf(const std::string& file, const aiScene& scene) {
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
        throw Error(file + ": a face names a vertex that does not exist; export the mesh again");
      }
      read.mesh.triangles.push_back({offset + corner[0], offset + corner[1], offset + corner[2]});
    }
  }
  begin.push_back(static_cast<std::uint32_t>(read.mesh.triangles.size()));
  NameParts(scene, *scene.mRootNode, begin, read.groups);
  return read;
}

ImportedMesh Read(const std::string& file, std::string_view text) {
  const std::string format = MeshFormatOf(file);
  try {
    CheckDeclaredSize(format, text);
  } catch (const Error& error) {
    throw Error(file + ": " + error.what());
  }
  Assimp::Importer importer;
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE,
                              aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  importer.SetPropertyBool(AI_CONFIG_PP_PTV_KEEP_HIERARCHY, true);  // else parts lose their names
  KeepOnlyImporterOf(format, importer);
  auto* files = new OnlyTheseFiles;  // the importer's from now on
  importer.SetIOHandler(files);
  const std::string name = "mesh." + format;
  files->Add(name, text);
  for (const MeshReference& reference : FindMeshReferences(file, text)) {
    if (IsPackedMesh(file)) {
      throw Error(file + ": names a second file, \"" + reference.uri +
                  "\", which a packed mesh may not; unpack it, or export a .glb");
    }
    try {
      files->Own(reference.uri, ReadWholeFile(reference.file, kLargestMeshFile));
    } catch (const Error& error) {
      throw Error(file + ": its buffer is missing (" + error.what() +
                  "); keep it beside the mesh, or export a .glb, which holds it");
    }
  }
  const aiScene* scene = importer.ReadFile(
      name, aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_PreTransformVertices);
  const std::string why = scene == nullptr              ? importer.GetErrorString()
                          : scene->mRootNode == nullptr ? "it holds no scene"
                                                        : "";
  // assimp catches this one, but not every one.
  if (why == std::bad_alloc().what()) throw std::bad_alloc();
  if (!why.empty()) {
    throw Error(file + ": cannot be read (" + why +
                "); the file is damaged or in another format than its name says, export it again");
  }
  return MeshOf(file, *scene);
}

/// How far from its origin a mesh lies, and how large it is.
struct Place {
  double farthest = 0.0, longest = 0.0;
};

Place PlaceOf(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Vec3& v : mesh.vertices) {
    if (v.allFinite()) box.extend(v);
  }
  if (box.isEmpty()) return {};
  return {std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff()),
          box.sizes().maxCoeff()};
}

constexpr double kStep = 0x1p-23;  // from one number to the next, by its size

/// assimp keeps coordinates in single precision, as most formats' files do: far from the origin
/// they lie further apart than a hand feels, and triangles collapse.
bool IsFarOff(const Place& place) {
  constexpr double kCoarsest = 1e-4;  // of the longest side: 5 um of 50 mm
  return kStep * place.farthest > kCoarsest * place.longest;
}

/// The mesh once more, in double precision where the file has it; nothing after can mend what
/// collapsed.
ImportedMesh ReadFarOff(const std::string& file, std::string_view text, const Place& place) {
  if (const auto moved = MoveToOrigin(MeshFormatOf(file), text)) {
    ImportedMesh read = Read(file, moved->text);
    if (const Place near = PlaceOf(read.mesh); !IsFarOff(near) && near.longest > 0.0) {
      for (Vec3& v : read.mesh.vertices) v += moved->by;
      return read;
    }
  }
  throw Error(fmt::format(
      "{}: is {:.3g} across and lies {:.3g} from its origin, where numbers of single precision are "
      "{:.2g} apart; move the mesh to its origin in a mesh editor and export it again",
      file, place.longest, place.farthest, kStep * place.farthest));
}

}  // namespace

ImportedMesh ReadMeshFile(const std::string& file) {
  return ReadMeshText(file,
                      IsPackedMesh(file) ? Unpack(file) : ReadWholeFile(file, kLargestMeshFile));
}

ImportedMesh ReadMeshText(const std::string& file, std::string_view text) {
  ImportedMesh read = Read(file, text);
  if (const Place place = PlaceOf(read.mesh); IsFarOff(place)) {
    read = ReadFarOff(file, text, place);
  }
  Weld(read.mesh);
  return read;
}

}  // namespace palpate
