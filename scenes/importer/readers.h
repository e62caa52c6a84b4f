#pragma once

#include <string>
#include <string_view>

#include "scenes/mesh/mesh_packet.h"

// A reader for each format.  Each takes a whole file and gives what it says, with the vertices as
// they stand there, or throws Error with what is wrong and the remedy.  Nothing but geometry is
// looked at: normals, colours and materials may be what they like.
namespace palpate {

/// What a file holds.
struct FileContents {
  ImportedMesh read;
  /// How far apart neighbouring numbers of its coordinates are at the most, for the precision that
  /// the file keeps them in; 0: for that of double or of text [file unit].
  double step = 0.0;
};

/// From one number of single precision to the next, by its size.
inline constexpr double kSingleStep = 0x1p-23;

/// @param file  names it, for messages and for its buffers (mesh_references.h).
FileContents ReadObj(const std::string& file, std::string_view text);
FileContents ReadStl(const std::string& file, std::string_view text);
FileContents ReadPly(const std::string& file, std::string_view text);
FileContents ReadGltf(const std::string& file, std::string_view text);  ///< .gltf and .glb
/// By assimp, which a damaged file may crash.
FileContents Read3ds(const std::string& file, std::string_view text);

/// The number of the largest size among all finite ones.
double FarthestOf(const TriangleMesh& mesh);

}  // namespace palpate
