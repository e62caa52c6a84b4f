#pragma once

#include <cstdint>
#include <vector>

#include "scenes/mesh/mesh_query.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/scene.h"

namespace palpate {

/// A piece of a mesh, with numbers of its own for its vertices.
struct MeshPiece {
  TriangleMesh mesh;
  std::vector<std::uint32_t> triangle;  ///< of the whole mesh, of each
  std::vector<std::uint32_t> vertex;    ///< of the whole mesh, of each
  MeshReport report;
};

/// Pieces, in the order of their first triangles.  What edges of two triangles join, and is closed,
/// is one, whatever touches it at a vertex or an edge: a body with a fin is a body and a sheet.  Of
/// all else, pieces share no vertex.
std::vector<MeshPiece> PiecesOf(const TriangleMesh& mesh);

/// The same of a mesh that has several; else none, for of most meshes the one piece is the whole.
std::vector<MeshPiece> SeveralPiecesOf(const TriangleMesh& mesh);

/// Of each triangle the number of its patch, from 0: what edges of exactly two triangles join.  No
/// patch is of two pieces.
std::vector<std::uint32_t> PatchesOf(const TriangleMesh& mesh);

/// The triangles of each number 0, 1, ..., of which `number` gives one to each triangle.
std::vector<MeshPiece> PiecesBy(const TriangleMesh& mesh, const std::vector<std::uint32_t>& number);

/// Winding number just behind a piece's faces, on average: 1 of a closed one that is turned right,
/// 1/2 of a flat sheet, 0 of a closed one that is inside out, and between them for open shells.
/// @param whole  of the mesh that the piece is of, whose other pieces count, too.
double Enclosure(const TriangleMesh& piece, const MeshQuery& whole);

/// Pieces below this are shells inside out, above that they are shells, and sheets between them.
/// Half of a sphere without its lid has 0.76, and four sides of a cube 0.7.
inline constexpr double kInsideOutShell = 0.3, kShell = 0.7;

}  // namespace palpate
