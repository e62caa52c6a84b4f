#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "scenes/scene.h"

namespace palpate {

/// The largest max_triangles that a scene file may give.
inline constexpr std::size_t kMaxCurvedTriangles = 4'000'000;

struct CurvedOptions {
  /// The largest distance of a triangle from the curved patch that it approximates [m]; > 0.
  double tolerance = 3e-6;
  /// The most triangles of the refined mesh.  If more are needed, the tolerance is doubled
  /// until these suffice.
  std::size_t max_triangles = 400'000;

  bool operator==(const CurvedOptions&) const = default;
};

struct CurvedMesh {
  /// The input's vertices, then the new ones.  Triangles come in the order of
  /// their source triangles.
  TriangleMesh mesh;
  std::vector<std::uint32_t> source;  ///< for each triangle, the input triangle that it is part of
  double tolerance = 0.0;             ///< that was kept [m]: the requested one times 1, 2, 4, 8 ...
};

/// Refines a coarse mesh of a smooth surface.  Each triangle represents a curved patch, and is
/// divided until no triangle is farther from its patch than the tolerance.
///
///             m              An edge becomes a parabola through its ends a and b.  Its tangent
///         .  - -  .          in a is the edge, turned into the tangent plane of the normal in
///       a --------- b        a; likewise in b.  The height of its middle, m, is that of a
///                            circular arc that turns as much from a to b.
///
/// The patch is the quadratic one that the three parabolas bound, as in T. Nagata, CAGD 22 (2005)
/// 327-347.  His parabola takes both tangents exactly, and diverges where the normals are nearly
/// parallel and lean the same way, at an inflection.  This one takes only the difference of the
/// tangents, which is all that a parabola can represent, and is flat there.
///
/// Normals are Max's, as in ContactMesh, with one for each smooth sector of a corner.  Edges at
/// which faces meet at more than 40 degrees are creases and stay sharp.  A crease curves along
/// itself if both of its sides do: its tangent is common to both, so the rim of a cylinder
/// becomes round and its lid stays flat.  An edge stays straight if it does not have two
/// triangles, if one of them has no area, or if they wind against each other.  So do the edges of
/// a patch that would fold, penetrate another part of the mesh, or face a neighbour across a
/// notch of less than 60 degrees.
///
/// All points of an edge are computed from that edge alone, so refining adds no cracks.  A
/// point moves by at most 0.12 of its patch's longest edge.  Flat meshes are returned bit
/// for bit.  Deterministic.
/// @param mesh  finite, with indices in range.
CurvedMesh RefineCurved(const TriangleMesh& mesh, const CurvedOptions& options);

}  // namespace palpate
