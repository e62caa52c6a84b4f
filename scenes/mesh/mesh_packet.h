#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "scenes/scene.h"

namespace palpate {

/// A named part of a mesh file (an OBJ's object or group, a 3DS or glTF mesh or node, an STL
/// solid): triangles [begin, end).  Several parts may have the same name.
struct MeshGroup {
  std::string name;
  std::uint32_t begin = 0, end = 0;
};

/// The contents of a mesh file.
struct ImportedMesh {
  TriangleMesh mesh;
  std::vector<MeshGroup> groups;
};

/// Packs a mesh into the bytes that palpate-import hands to the program that started it:
/// counts, then vertices, triangles and parts, in the machine's own layout, because both ends
/// are of one build.
std::string PackMesh(const ImportedMesh& read);

/// Unpacks such bytes.  Does not trust the sender, which may have been corrupted by a damaged file:
/// checks that sizes add up to the last byte and that parts lie within the triangles.  InspectMesh
/// checks the vertex indices.  Throws Error without the file's name.
ImportedMesh UnpackMesh(std::string_view bytes);

}  // namespace palpate
