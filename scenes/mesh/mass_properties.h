#pragma once

#include <optional>

#include "scenes/scene.h"

namespace palpate {

/// What a solid of density 1 weighs.
struct MassProperties {
  double volume = 0.0;              ///< [m^3]
  Vec3 centre = Vec3::Zero();       ///< of volume [m]
  Mat3 inertia = Mat3::Identity();  ///< about the centre, of density 1 [m^5]
};

/// Returns the volume integrals of a closed mesh that is placed at X_WB, in W: exact but for
/// rounding, as sums over the tetrahedra between its triangles and a point (Mirtich, J. Graphics
/// Tools 1 (1996) 31-50, has the integrals; Tonon, J. Math. Stat. 1 (2004) 8-11, those of a
/// tetrahedron).  Nothing if an edge has not as many triangles on one side as on the other, or if
/// the volume is not positive.
std::optional<MassProperties> MassOf(const TriangleMesh& mesh, const Pose& X_WB);

}  // namespace palpate
