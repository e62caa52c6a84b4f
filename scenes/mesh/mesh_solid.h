#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scenes/scene.h"

namespace palpate {

/// The closed solid that a mesh stands for where the mesh itself is open.  What is seen, and felt
/// where meshes are felt, is the mesh; spheres, and what is said of them, go by this solid.
/// A piece that encloses something (Enclosure, mesh_pieces.h) and has a wide opening gets a lid,
/// the flat cone over each of its openings; small holes stay, for no sphere comes far through them.
/// A sheet encloses nothing: it gets a plate behind its faces.  Surface inside the solid is
/// taken, for balls need not end there.
struct MeshSolid {
  TriangleMesh mesh;  ///< the triangles that came, and after them the new ones
  /// Of the first of the new ones, which are parts of triangles that came: which.
  std::vector<std::uint32_t> part_of;
  double opening = 0.0;    ///< the widest that a lid closes: its box's diagonal; 0: no lid
  double thickness = 0.0;  ///< of the plate behind a sheet; 0: no sheet

  bool added() const { return opening > 0.0 || thickness > 0.0; }

  static constexpr std::uint32_t kNone = 0xffffffffu;
  /// Of a triangle of the solid, the one that it is, or is a part of; kNone where there is none.
  /// @param came  how many there were.
  std::uint32_t OriginOf(std::uint32_t triangle, std::size_t came) const {
    if (triangle < came) return triangle;
    return triangle - came < part_of.size() ? part_of[triangle - came] : kNone;
  }
};

/// @param mesh  finite, oriented as far as it can be (mesh_orient.h).  Deterministic.
MeshSolid SolidOf(const TriangleMesh& mesh);

/// For people: what was added; empty where nothing was.
/// @param scale, unit  what the mesh's numbers are multiplied by, and then are of.
std::string SolidRemark(const MeshSolid& solid, double scale, const std::string& unit);

/// Gives the open pieces of a mesh a thickness, behind their faces: a second face, and walls along
/// their open edges.  Of two triangles with the same corners one is left, so that two faces back to
/// back become one.  Returns false where nothing is open.
bool Thicken(double thickness, TriangleMesh& mesh);

}  // namespace palpate
