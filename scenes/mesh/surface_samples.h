#pragma once

#include <cstdint>
#include <vector>

#include "common/math/pose.h"
#include "scenes/mesh/mesh_query.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/scene.h"

namespace palpate {

/// A point of the surface; `outward` is the unit normal of its triangle, away from the solid.
struct SurfaceSample {
  Vec3 point, outward;
  std::uint32_t triangle = 0;
};

/// About `count` samples spread at random with equal density over the surface, the same ones in
/// every run.  Walls inside the
/// solid, which the winding number tells, get none.
std::vector<SurfaceSample> ScatterSamples(const TriangleMesh& mesh, const MeshReport& report,
                                          const MeshQuery& query, std::size_t count);

/// About `count` points at `height` above the surface, spread with equal density over where the
/// centre of a ball with that radius can be that touches the surface from outside: beside faces,
/// round convex edges and round corners, and not in creases that it does not reach.  So a place
/// counts as much as such a ball is likely to touch it (for a smooth surface with the principal
/// curvatures k1 and k2, (1 + k1 height)(1 + k2 height) of its area).  `outward` leads away from
/// the place that is touched, `triangle` is one that holds it.  The same points in every run.
/// @param height  above 0 [m].
std::vector<SurfaceSample> ScatterAbove(const TriangleMesh& mesh, const MeshReport& report,
                                        const MeshQuery& query, double height, std::size_t count);

/// Chooses `keep` samples that lie as evenly as a Poisson disc pattern, by removing the most
/// crowded (Yuksel, Sample Elimination for Generating Poisson Disk Sample Sets, Eurographics 2015).
/// Samples that face opposite ways, as on the two sides of a thin wall, do not crowd each other.
/// Returns indices, ascending.
std::vector<std::uint32_t> ThinOut(const std::vector<SurfaceSample>& samples, std::size_t keep,
                                   double area);

/// Largest possible Poisson disc radius of `count` samples on an area [m].
double PoissonRadius(double area, std::size_t count);

}  // namespace palpate
