#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "scenes/mesh/mesh_format.h"
#include "scenes/mesh/mesh_packet.h"
#include "scenes/scene.h"

namespace palpate {

/// Of what ImportMesh makes of a file: part of the key of cached scenes.
inline constexpr std::uint32_t kMeshReadersVersion = 1;

/// Reads a mesh in the file's own unit and frame: OBJ, STL, PLY, 3DS, glTF 2.0 (.gltf, .glb), each
/// also gzipped (.gz), except for glTF whose data stand in a second file.  Polygons become
/// triangles, a file's many parts one mesh, and corners at the same place one vertex.
///
/// The file is read by a process of its own, palpate-import, with limits on its time and memory
/// (mesh_import_limits.h): a file that crashes its importer, or hangs it, is an Error like any
/// other.
/// @param groups  where given, the file's named parts are added to it.
/// Throws Error with the reason and a remedy.  The mesh is not judged yet: see mesh_report.h.
TriangleMesh ImportMesh(const std::string& file, std::vector<MeshGroup>* groups = nullptr);

/// Every file that decides what ImportMesh returns: the mesh, and what it refers to
/// (mesh_references.h).  Throws Error where one of them is not there.
std::vector<std::string> FilesOfMesh(const std::string& file);

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
/// Returns what a number in the file means [m].
double PlaceMesh(const MeshPlacement& placement, TriangleMesh& mesh);

/// For people: the unit that a file more likely means, where the mesh has hardly the size that
/// somebody wants to feel; else empty, as where the scene says how long it is to be.
/// @param mesh  placed.
std::string UnitRemark(const MeshPlacement& placement, const TriangleMesh& mesh);

}  // namespace palpate
