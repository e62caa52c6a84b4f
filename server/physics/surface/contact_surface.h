#pragma once

#include <cstdint>
#include <vector>

#include "common/math/pose.h"
#include "scenes/scene.h"
#include "scenes/sphere_tree.h"
#include "server/physics/simd/kernels.h"

namespace palpate {

/// How far an edge may bend away from its ends before a point of its own samples it [m].
inline constexpr double kBump = 20e-6;

/// A convex crease of a surface.
struct CreaseSegment {
  Vec3 a, d;    ///< from a to a + d
  Vec3 t0, t1;  ///< unit, across the edge, into the two faces that meet there
};

/// The true surface of a body, as surface contact wants it (ContactModel::kSurface): patches that
/// tile it (surface_mesh.h), points that may touch patches of another surface, and creases that may
/// touch another's.  A touch of two surfaces is one of
///   - two smooth places: a point against a patch, by the side whose points lie closer,
///   - a crease or corner against a smooth place: points along the crease against a patch,
///   - two creases that cross,
/// so rows of these three kinds keep the surfaces apart.  Each kind has a tree of balls for the
/// prediction; every patch lies in the ball of its leaf, so no place is left out.
/// Between its points a smooth surface may stand out by kBump, two hundredths of a newton at
/// 1 N/mm.  A plane touches with its corners and creases alone, or with another's points.
/// Frame: that of X_FB.  Immutable.
class ContactSurface {
 public:
  /// @param mesh   oriented, frame B [m]
  /// @param leaves  the body's sphere tree: how finely the surface is cut, and which leaf each of
  ///                its pieces belongs to
  ContactSurface(const TriangleMesh& mesh, const SphereTree& leaves, const Pose& X_FB);

  std::vector<SurfacePoint> points;
  std::vector<SurfacePatch> patches;
  std::vector<PatchDisc> discs;  ///< of each patch
  std::vector<CreaseSegment> creases;
  std::vector<std::uint32_t> point_leaf, patch_leaf, crease_leaf;  ///< leaf of the sphere tree
  /// Balls that hold them, leaf i that of entry i (surface_tree.h).
  SphereTree point_tree, patch_tree, crease_tree;
};

}  // namespace palpate
