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

/// Returns about `count` samples spread at random with equal density over the surface, the same
/// ones in every run.  Surface inside the solid, by the winding number, gets none.
std::vector<SurfaceSample> ScatterSamples(const TriangleMesh& mesh, const MeshReport& report,
                                          const MeshQuery& query, std::size_t count);

/// Returns about `count` points at `height` above the surface, the same ones in every run: possible
/// centres of a ball of that radius that touches the surface from outside.  They are spread with
/// equal density beside faces, round convex edges and round corners, but not in creases that the
/// ball does not reach.  So a place counts in proportion to how likely such a ball touches it (on a
/// smooth surface with the principal curvatures k1 and k2: (1 + k1 height)(1 + k2 height) of its
/// area). `outward` points away from the place that is touched, and `triangle` contains that place.
/// @param height  above 0 [m].
std::vector<SurfaceSample> ScatterAbove(const TriangleMesh& mesh, const MeshReport& report,
                                        const MeshQuery& query, double height, std::size_t count);

/// Chooses `keep` samples that lie as evenly as a Poisson disc pattern, by removing the most
/// crowded ones (Yuksel, Sample Elimination for Generating Poisson Disk Sample Sets, Eurographics
/// 2015).  Samples that face opposite ways, as on the two sides of a thin wall, do not crowd each
/// other.  Returns indices, ascending.
std::vector<std::uint32_t> ThinOut(const std::vector<SurfaceSample>& samples, std::size_t keep,
                                   double area);

/// Returns the largest possible Poisson disc radius of `count` samples on an area [m].
double PoissonRadius(double area, std::size_t count);

}  // namespace palpate
