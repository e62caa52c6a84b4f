#pragma once

#include <cstddef>
#include <vector>

#include "scenes/mesh/mesh_query.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/mesh/surface_samples.h"
#include "scenes/scene.h"
#include "scenes/tree/sphere.h"

namespace palpate {

/// Statistics of a set of values.
struct Distribution {
  double mean = 0.0, rms = 0.0, p1 = 0.0, p50 = 0.0, p99 = 0.0, min = 0.0, max = 0.0;
};

/// Returns the statistics of the values; all zero if there are none.
Distribution DistributionOf(std::vector<double> values);

/// The difference between a union of balls and the solid that it represents.  At points spread
/// evenly over the surface, the line along the triangle's normal is followed to where it leaves the
/// union; it starts at the point or, if the union does not reach that, inside the solid.
struct UnionError {
  std::size_t spheres = 0;
  Distribution offset;           ///< height of the union over the surface [m], negative below it
  Distribution tilt;             ///< angle between the normals of surface and union [rad]
  Distribution protrusion;       ///< for each ball, how far it sticks out of the solid [m]
  Distribution bareness;         ///< of the surface, distance to the union, 0 within it [m]
  double uncovered_share = 0.0;  ///< share of the surface that lies in no ball
  double missed_share = 0.0;     ///< share of the surface whose normal meets no ball
  /// Error in height for a finger that follows the surface, up or down, which 95 % of places do not
  /// exceed [m]: |offset|, or the distance to the union if the normal meets no ball.
  double off_p95 = 0.0;
  /// Mean error in the direction of the force of a light touch [rad]: the tilt, or a right angle if
  /// the normal meets no ball.
  double mean_lean = 0.0;
  /// Volume of the union over the solid's; 0 if the mesh encloses none.
  double volume_ratio = 0.0;
};

/// Returns the height of a union over each point of the surface, along its normal [m]; NaN if the
/// normal meets no ball.
/// @param furthest  the length to which normals are followed, up and down [m].
std::vector<double> OffsetsAt(const std::vector<SurfaceSample>& points, const SphereQuery& balls,
                              double furthest);

/// Measures unions of balls against a solid's surface; what the measurements share is made once.
/// Set-up only.  Deterministic; uses other points than those that trees are built with.
class SurfaceGauge {
 public:
  /// @param solid    must outlive this.
  /// @param samples  number of points on the surface, and of points in the box for the volume.
  SurfaceGauge(const TriangleMesh& solid, std::size_t samples);
  SurfaceGauge(const SurfaceGauge&) = delete;
  SurfaceGauge& operator=(const SurfaceGauge&) = delete;

  enum class Figures {
    kAll,
    kSurface,  ///< all but protrusion and volume_ratio, which take as long again
  };
  UnionError Measure(const std::vector<Sphere>& balls, Figures figures = Figures::kAll) const;
  /// of the solid's box
  double diagonal() const { return (report_.box_max - report_.box_min).norm(); }

 private:
  std::size_t samples_;
  MeshReport report_;
  MeshQuery query_;
  std::vector<SurfaceSample> points_;
};

/// Returns the balls of each level of a tree, coarsest first, and the leaves last.  All others
/// bound what is below them.
std::vector<std::vector<Sphere>> BallsByLevel(const SphereTree& tree);

/// Measures each level with SurfaceGauge, against the solid that the mesh
/// represents (mesh_solid.h).
std::vector<UnionError> MeasureLevels(const TriangleMesh& mesh, const SphereTree& tree,
                                      std::size_t samples = 100003);

/// How well a tree's leaves represent its mesh [m]: the parts of UnionError that take least time.
struct Coverage {
  Distribution outside;    ///< for each leaf, how far it sticks out of the solid
  Distribution uncovered;  ///< for points all over the surface, the distance to the nearest leaf
};

/// Measures that.  Set-up only.  Deterministic.
/// @param samples  number of points on the surface.
Coverage MeasureCoverage(const TriangleMesh& mesh, const SphereTree& tree,
                         std::size_t samples = 100000);

}  // namespace palpate
