#pragma once

#include <cstddef>
#include <vector>

#include "scenes/mesh/mesh_query.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/mesh/surface_samples.h"
#include "scenes/scene.h"
#include "scenes/tree/sphere.h"

namespace palpate {

/// How a quantity is spread.
struct Distribution {
  double mean = 0.0, rms = 0.0, p1 = 0.0, p50 = 0.0, p99 = 0.0, min = 0.0, max = 0.0;
};

/// All zero of no values.
Distribution DistributionOf(std::vector<double> values);

/// How far a union of balls is from the solid that it stands for.  At points all over the surface,
/// as many on equal areas, the line along the triangle's normal is followed to where it leaves the
/// union: at once or from inside the solid where the union does not reach the point.
struct UnionError {
  std::size_t spheres = 0;
  Distribution offset;           ///< height of the union over the surface [m]; below it < 0
  Distribution tilt;             ///< angle between both normals there [rad]
  Distribution protrusion;       ///< of each ball: how far it sticks out of the solid [m]
  Distribution bareness;         ///< of the surface: distance to the union, 0 within it [m]
  double uncovered_share = 0.0;  ///< of the surface: lies in no ball
  double missed_share = 0.0;     ///< of the surface: its normal meets no ball at all
  /// What a finger that follows the surface is off by, up or down, at 95 of 100 places [m]: the
  /// offset's size, and where the normal meets no ball the distance to the union.
  double off_p95 = 0.0;
  /// How far the force of a light touch leans, on average [rad]: the tilt, and a right angle where
  /// the normal meets no ball.
  double mean_lean = 0.0;
  /// Volume of the union over the solid's; 0 where the mesh encloses none.
  double volume_ratio = 0.0;
};

/// Heights of a union over the surface along its normals [m], one a point; NaN where the normal
/// meets no ball.
/// @param furthest  the length of a normal, up and down [m].
std::vector<double> OffsetsAt(const std::vector<SurfaceSample>& points, const SphereQuery& balls,
                              double furthest);

/// A solid's surface, to measure unions of balls against: what they share is made once.
/// Set-up only.  Deterministic; the points are others than those that a tree was built with.
class SurfaceGauge {
 public:
  /// @param solid    must outlive this.
  /// @param samples  points of the surface, and as many in the box for the volume.
  SurfaceGauge(const TriangleMesh& solid, std::size_t samples);
  SurfaceGauge(const SurfaceGauge&) = delete;
  SurfaceGauge& operator=(const SurfaceGauge&) = delete;

  enum class Figures {
    kAll,
    kSurface,  ///< neither protrusion nor volume_ratio, which take as long again
  };
  UnionError Measure(const std::vector<Sphere>& balls, Figures figures = Figures::kAll) const;
  double diagonal() const { return (report_.box_max - report_.box_min).norm(); }  ///< of its box

 private:
  std::size_t samples_;
  MeshReport report_;
  MeshQuery query_;
  std::vector<SurfaceSample> points_;
};

/// The balls of each level of a tree, coarsest first; the last are its leaves.  The others bound
/// what is below them.
std::vector<std::vector<Sphere>> BallsByLevel(const SphereTree& tree);

/// What SurfaceGauge measures of each level, against the solid that the mesh stands for
/// (mesh_solid.h).
std::vector<UnionError> MeasureLevels(const TriangleMesh& mesh, const SphereTree& tree,
                                      std::size_t samples = 100003);

/// How well a sphere tree's leaves stand for its mesh [m]: of UnionError what takes the least time.
struct Coverage {
  Distribution outside;    ///< of each leaf: how far it sticks out of the solid
  Distribution uncovered;  ///< of points all over the surface: distance to the nearest leaf
};

/// Set-up only.  Deterministic.
/// @param samples  points of the surface.
Coverage MeasureCoverage(const TriangleMesh& mesh, const SphereTree& tree,
                         std::size_t samples = 100000);

}  // namespace palpate
