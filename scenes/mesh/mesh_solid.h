#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scenes/scene.h"

namespace palpate {

/// The closed solid that an open mesh represents.  People see the mesh, and feel it if meshes are
/// felt; the sphere tree, and what is reported about it, are based on this solid.
/// A piece that encloses something (Enclosure, mesh_pieces.h) and has a wide opening gets a lid: a
/// flat cone over each opening.  Small holes stay, because no sphere protrudes far through them.  A
/// sheet encloses nothing, so it gets a plate behind its faces.  Surface inside the solid is
/// removed, because balls need not end there.
struct MeshSolid {
  TriangleMesh mesh;  ///< the input's triangles, then the new ones
  /// For each of the first new triangles, those that are parts of input triangles: which one.
  std::vector<std::uint32_t> part_of;
  double opening = 0.0;  ///< diagonal of the box of the widest opening that a lid closes; 0: no lid
  double thickness = 0.0;  ///< of the plate behind a sheet; 0: no sheet

  bool added() const { return opening > 0.0 || thickness > 0.0; }

  static constexpr std::uint32_t kNone = 0xffffffffu;
  /// Returns the input triangle that a triangle of the solid is, or is a part of; kNone if
  /// there is none.
  /// @param came  number of input triangles.
  std::uint32_t OriginOf(std::uint32_t triangle, std::size_t came) const {
    if (triangle < came) return triangle;
    return triangle - came < part_of.size() ? part_of[triangle - came] : kNone;
  }
};

/// Returns the solid of a mesh.  Deterministic.
/// @param mesh  finite, and oriented as far as possible (mesh_orient.h).
MeshSolid SolidOf(const TriangleMesh& mesh);

/// Returns what was added, for people; empty if nothing was.
/// @param scale, unit  factor from the mesh's numbers to the unit to write, and that unit's name.
std::string SolidRemark(const MeshSolid& solid, double scale, const std::string& unit);

/// Gives the open pieces of a mesh a thickness behind their faces: a second face, and walls along
/// their open edges.  Of triangles with the same corners only the first counts, so two faces back
/// to back become one.  Returns false if nothing is open.
bool Thicken(double thickness, TriangleMesh& mesh);

}  // namespace palpate
