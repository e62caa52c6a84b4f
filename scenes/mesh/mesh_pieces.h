#pragma once

#include <cstdint>
#include <vector>

#include "scenes/mesh/mesh_query.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/scene.h"

namespace palpate {

/// A piece of a mesh, with its own numbering of vertices.
struct MeshPiece {
  TriangleMesh mesh;
  std::vector<std::uint32_t> triangle;  ///< for each triangle, its index in the whole mesh
  std::vector<std::uint32_t> vertex;    ///< for each vertex, its index in the whole mesh
  MeshReport report;
};

/// Returns the pieces, in the order of their first triangles.  Triangles that are joined by
/// edges of two triangles and form a closed surface are one piece, whatever touches it at a
/// vertex or an edge: a body with a fin is a body and a sheet.  All other pieces share no vertex
/// with each other.
std::vector<MeshPiece> PiecesOf(const TriangleMesh& mesh);

/// Returns the pieces of a mesh that has several; else none, to spare a copy of the whole mesh.
std::vector<MeshPiece> SeveralPiecesOf(const TriangleMesh& mesh);

/// Returns for each triangle the number of its patch, from 0.  A patch is what edges of exactly two
/// triangles join; it lies within one piece.
std::vector<std::uint32_t> PatchesOf(const TriangleMesh& mesh);

/// Returns one piece for each number 0, 1, ...: the triangles to which `number` assigns it.
std::vector<MeshPiece> PiecesBy(const TriangleMesh& mesh, const std::vector<std::uint32_t>& number);

/// Returns the mean winding number just behind a piece's faces: 1 for a closed piece that is
/// wound outwards, 1/2 for a flat sheet, 0 for a closed piece that is inside out, and values
/// between for open shells.
/// @param whole  the mesh that contains the piece; its other pieces count, too.
double Enclosure(const TriangleMesh& piece, const MeshQuery& whole);

/// Bounds of Enclosure: pieces below the first are shells inside out, those above the second
/// are shells, and sheets lie between.  Half a sphere without a lid has 0.76, and four sides of
/// a cube 0.7.
inline constexpr double kInsideOutShell = 0.3, kShell = 0.7;

}  // namespace palpate
