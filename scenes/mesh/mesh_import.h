#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scenes/mesh/mesh_format.h"
#include "scenes/mesh/mesh_packet.h"
#include "scenes/scene.h"

namespace palpate {

/// Reads a mesh in the file's own unit and frame: OBJ, STL, PLY, 3DS, glTF 2.0 (.gltf, .glb), each
/// also gzipped (.gz), except for glTF whose data are in a second file.  Polygons are split into
/// triangles, all parts of a file become one mesh, and vertices at the same place become one.
///
/// A process of its own, palpate-import, reads the file, with limits on time and memory
/// (mesh_import_limits.h): a file that crashes or hangs it gives an Error like any other.
/// @param groups  if given, the file's named parts are added to it.
/// Throws Error with the reason and a remedy.  Does not check the mesh: see mesh_report.h.
TriangleMesh ImportMesh(const std::string& file, std::vector<MeshGroup>* groups = nullptr);

/// Returns all files that decide what ImportMesh returns: the mesh file, and those that it refers
/// to (mesh_references.h).  Throws Error if one of them does not exist.
std::vector<std::string> FilesOfMesh(const std::string& file);

/// How a mesh is brought from its file's unit and frame into the scene's, in metres.
struct MeshPlacement {
  enum class Origin {
    kFile,       ///< as in the file
    kBoxCentre,  ///< the centre of the bounding box
    kCentroid,   ///< the centre of the solid's volume; of the surface if the mesh is open
  };
  double metres_per_unit = 1.0;             ///< ignored if longest_side is given
  std::optional<double> longest_side = {};  ///< of the bounding box, after scaling [m]
  Origin origin = Origin::kBoxCentre;
};

/// Scales and moves a mesh, which must have an extent (mesh_report.h).
void PlaceMesh(const MeshPlacement& placement, TriangleMesh& mesh);

/// Returns a remark for people about the file's unit, if the mesh is hardly of a size that can be
/// felt and another unit is more likely; else empty, also if the scene gives the longest side.
/// @param mesh  placed.
std::string UnitRemark(const MeshPlacement& placement, const TriangleMesh& mesh);

}  // namespace palpate
