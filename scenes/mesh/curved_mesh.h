#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "scenes/scene.h"

namespace palpate {

/// Changes with every change of what a refined mesh looks like, so that cached scenes are built
/// anew.
inline constexpr std::uint32_t kCurvedMeshVersion = 1;

/// The most that a scene file may ask for.
inline constexpr std::size_t kMaxCurvedTriangles = 4'000'000;

struct CurvedOptions {
  /// How far a triangle may leave the curved patch that it stands for [m]; > 0.
  double tolerance = 3e-6;
  /// The most triangles of the refined mesh.  Where more are needed, the tolerance is doubled until
  /// they suffice.
  std::size_t max_triangles = 400'000;

  bool operator==(const CurvedOptions&) const = default;
};

struct CurvedMesh {
  /// The vertices that came, and after them the new ones.  The triangles in the order of those that
  /// they come of.
  TriangleMesh mesh;
  std::vector<std::uint32_t> source;  ///< of each triangle: the one that it comes of
  double tolerance = 0.0;  ///< that was kept [m]: what was asked for, or 2, 4, 8 ... of it
};

/// Refines a coarse mesh of a smooth surface: each triangle stands for a curved patch, and is
/// divided until no triangle leaves its patch by more than the tolerance.
///
///             m              An edge becomes a parabola through its ends a and b.  In a its
///         .  - -  .          tangent is the edge, turned into the plane that the normal of a
///       a --------- b        leaves; in b likewise.  The height of its middle, m, is that of an
///                            arc of a circle that turns as much from a to b.
///
/// The patch is the quadratic one that the three parabolas bound, as in T. Nagata, CAGD 22 (2005)
/// 327-347.  His parabola takes both tangents exactly and runs away where the normals are nearly
/// parallel and lean the same way, an inflection; this one takes the difference of the tangents,
/// which is all that a parabola can have, and is flat there.
///
/// Normals are Max's, as in ContactMesh, apart for each smooth sector of a corner.  What meets at
/// more than 40 degrees is a crease, which stays sharp.  It curves along itself where both of its
/// sides do: its tangent is common to both, so a cylinder's rim becomes round and its lid stays
/// flat.  Edges stay straight that have not two triangles, or have one without area, or whose sides
/// wind against each other.  So do those of a patch that would fold, or come into another part of
/// the mesh, or face a neighbour across a notch of less than 60 degrees.
///
/// All points of an edge come of the edge alone, so the refined mesh has no crack where the mesh
/// has none.  A point moves by at most 0.12 of its patch's longest edge.  Flat meshes come back as
/// they were, to the bit.  Deterministic.
/// @param mesh  finite, with indices in range.
CurvedMesh RefineCurved(const TriangleMesh& mesh, const CurvedOptions& options);

}  // namespace palpate
