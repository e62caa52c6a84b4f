#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/math/pose.h"
#include "scenes/grid/cut_field.h"

namespace palpate {

/// Triangles of the surface of what is left, in one block or in all of them.
struct SolidSurface {
  std::vector<Vec3> vertices;  ///< B [m]
  /// The number of each vertex.  A vertex that two blocks share has the same number and the same
  /// bits in both.
  std::vector<std::uint64_t> numbers;
  /// Counter-clockwise seen from the free side.
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint8_t> materials;  ///< for each triangle, the material behind it

  void Clear();
};

/// A solid and the part of it that is gone.
struct SolidFields {
  const SolidGrid& solid;
  const SparseField& cut;  ///< a CutField's, or a copy of one
  /// If not null, replaces `cut` in those blocks of `later` that are not all solid.
  const SparseField* later = nullptr;
};

/// Takes the triangles of one block.  Each edge of the lattice, and the triangles across it,
/// belong to the block that holds the edge's lower end.  A block's triangles depend on the points
/// from 3 before the block to 2 beyond it, and those of their neighbours on the points from 5
/// before to 4 beyond: when a block has changed, the surface of the 27 blocks round it must be
/// made anew, and no other.
///
/// The method is dual contouring (Ju et al., ACM T. Graphics 21 (2002) 339-346).  Each lattice cell
/// that the surface crosses has a vertex where the tangent planes at the ends of its crossed edges
/// meet, and each crossed edge has a quad.  Each end takes its plane from the field that crosses
/// there, so the rim of a cut is sharp.  A cell has one vertex for each sheet of the surface in it
/// (Nielson, IEEE Visualization 2004, 489-496).  Where two sheets would share an edge between two
/// cells, which would give four triangles at one edge, the edge between the crossings is taken
/// instead.  Eight cells share one vertex if that changes neither the topology of the surface (Ju
/// et al., sec. 4.1) nor its place by more than h/20.  So the surface of all blocks is closed, and
/// every edge has two triangles, one each way.
///
/// Deterministic.  A block has at most 6,144 triangles (4 at each of its 3 x 512 edges) and 5,916
/// vertices (4 sheets in each of 9^3 cells, 3 x 10^3 crossings); a block of a tooth has some fifty.
/// Uses 170 kB of stack.
/// `cut`: the field of a CutField; `surface`: cleared first, its storage is used again.
void TakeSurface(const SolidGrid& solid, const SparseField& cut, std::size_t block,
                 SolidSurface& surface);

/// Takes the triangles of the block, and then those of its neighbours that share a vertex with
/// them.  Returns how many are the block's own; if it has none, there are no neighbours either.
std::size_t TakeSurfaceAndRim(const SolidFields& fields, std::size_t block, SolidSurface& surface);

/// Takes the surface of all blocks, in which shared vertices occur once.  For set-up and tools.
SolidSurface WholeSurface(const CutField& cut);

}  // namespace palpate
