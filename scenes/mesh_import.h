#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scenes/scene.h"

namespace palpate {

/// A named part of a mesh file (an OBJ's object or group, a 3DS or glTF mesh or node, an STL
/// solid): triangles [begin, end).  A part may come in several pieces of one name.
struct MeshGroup {
  std::string name;
  std::uint32_t begin = 0, end = 0;
};

/// Reads a mesh in the file's own unit and frame: OBJ, STL, PLY, 3DS, glTF (.gltf, .glb), each also
/// gzipped (.gz), except for glTF whose data stand in a second file.  Polygons become triangles,
/// a file's many parts one mesh, and corners at the same place one vertex.
/// @param groups  where given, the file's named parts are added to it.
/// Throws Error with the reason and a remedy.  The mesh is not judged yet: see mesh_report.h.
TriangleMesh ImportMesh(const std::string& file, std::vector<MeshGroup>* groups = nullptr);

/// True where the name ends as a mesh file's does.
bool IsMeshFile(const std::string& file);

/// How a mesh comes from its file's unit and frame into the scene's, in metres.
struct MeshPlacement {
  enum class Origin {
    kFile,       ///< as in the file
    kBoxCentre,  ///< centre of the bounding box
    kCentroid,   ///< centre of the solid's volume; of the surface where the mesh is open
  };
  double metres_per_unit = 1.0;        ///< not used where longest_side is given
  std::optional<double> longest_side;  ///< of the bounding box, after scaling [m]
  Origin origin = Origin::kBoxCentre;
};

/// Scales and centres.  The mesh must have an extent (mesh_report.h).
void PlaceMesh(const MeshPlacement& placement, TriangleMesh& mesh);

}  // namespace palpate
