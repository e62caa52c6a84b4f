#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/scene.h"

namespace palpate {

/// A named part of a mesh file (an OBJ's object or group, a 3DS or glTF mesh or node, an STL
/// solid): triangles [begin, end).  A part may come in several pieces of one name.
struct MeshGroup {
  std::string name;
  std::uint32_t begin = 0, end = 0;
};

/// What a mesh file holds.
struct ImportedMesh {
  TriangleMesh mesh;
  std::vector<MeshGroup> groups;
};

/// A mesh as bytes, in which palpate-import hands it to the program that started it: counts, then
/// vertices, triangles, and parts, each of the machine's own layout, for both ends are of one
/// build.
std::string PackMesh(const ImportedMesh& read);

/// The reader is suspicious: what has read a damaged file may have lost its mind.  Sizes must add
/// up to the last byte and parts lie within the triangles; that triangles name vertices is left to
/// InspectMesh.  Throws Error without the file's name.
ImportedMesh UnpackMesh(std::string_view bytes);

}  // namespace palpate
