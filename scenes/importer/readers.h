#pragma once

#include <string>
#include <string_view>

#include "scenes/mesh/mesh_packet.h"

// A reader for each format.  Each reads a whole file and returns its contents, with the vertices as
// they are in it, or throws Error with the defect and the remedy.  Only geometry is read: normals,
// colours and materials are ignored.
namespace palpate {

/// The contents of a file.
struct FileContents {
  ImportedMesh read;
  /// The largest distance between neighbouring values of the coordinates, at the precision of the
  /// file; 0: the precision of double or of text [file unit].
  double step = 0.0;
};

/// The relative distance from one number of single precision to the next.
inline constexpr double kSingleStep = 0x1p-23;

/// @param file  for its name in messages, and the place of its buffers (mesh_references.h).
FileContents ReadObj(const std::string& file, std::string_view text);
FileContents ReadStl(const std::string& file, std::string_view text);
FileContents ReadPly(const std::string& file, std::string_view text);
FileContents ReadGltf(const std::string& file, std::string_view text);  ///< .gltf and .glb
/// Uses assimp, which a damaged file may crash.
FileContents Read3ds(const std::string& file, std::string_view text);

/// Returns the largest absolute coordinate of the finite vertices.
double FarthestOf(const TriangleMesh& mesh);

}  // namespace palpate
