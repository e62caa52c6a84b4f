#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/math/pose.h"
#include "scenes/grid/cut_field.h"

namespace palpate {

/// Triangles of the surface of what is left, of a block or of all of it.
struct SolidSurface {
  std::vector<Vec3> vertices;  ///< B [m]
  /// Of each vertex; a vertex that two blocks share has the same number and the same bits in both.
  std::vector<std::uint64_t> numbers;
  /// Counter-clockwise seen from where it is free.
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint8_t> materials;  ///< of each triangle: what lies behind it

  void Clear();
};

/// A solid and what is gone of it.
struct SolidFields {
  const SolidGrid& solid;
  const SparseField& cut;  ///< a CutField's, or a copy of one
  /// Stands for `cut` in its blocks that are not all solid; null: in none.
  const SparseField* later = nullptr;
};

/// Each edge of the lattice belongs to the block of its lower end, and with it the triangles across
/// it.  They go by the points from 3 before the block to 2 beyond it, and those beside them from 5
/// to 4: where a block has changed, the surface of the 27 round it has to be made anew, and no
/// other.
///
/// Dual contouring (Ju et al., ACM T. Graphics 21 (2002) 339-346): a vertex for each cell of the
/// lattice that the surface crosses, where the faces meet that the ends of its crossed edges see,
/// and a quad across each edge that is crossed.  Each sees those of the field that crosses there,
/// so that the rim of a cut is sharp.  A cell has a vertex for each sheet of the surface in it
/// (Nielson, IEEE Visualization 2004, 489-496).  Where two sheets would share an edge between two
/// cells, which are four triangles at one edge, the edge between the crossings is taken instead.
/// Eight cells have one vertex where that changes neither how the surface hangs together (Ju et
/// al., sec. 4.1) nor, by more than h/20, where it lies.  So the surface of all blocks is closed,
/// and every edge has two triangles, one each way.
///
/// Deterministic.  Of a block at most 6,144 triangles (4 at each of its 3 x 512 edges) and 5,916
/// vertices (4 sheets in each of 9^3 cells, 3 x 10^3 crossings); a tooth's have some fifty.
/// 170 kB of the stack.
/// `cut`: what burs took away of the solid, a CutField's field; `surface`: cleared first, its
/// storage is used again.
void TakeSurface(const SolidGrid& solid, const SparseField& cut, std::size_t block,
                 SolidSurface& surface);

/// The same, and then the neighbours' triangles that share a vertex with the block's.  Returns how
/// many are the block's own; where it has none there are no neighbours either.
std::size_t TakeSurfaceAndRim(const SolidFields& fields, std::size_t block, SolidSurface& surface);

/// Of all blocks, vertices that they share once.  Set-up and tools.
SolidSurface WholeSurface(const CutField& cut);

}  // namespace palpate
