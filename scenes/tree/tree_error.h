#pragma once

#include <cstddef>
#include <vector>

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
  /// Volume of the union over the solid's; 0 where the mesh encloses none.
  double volume_ratio = 0.0;
};

/// Set-up only.  Deterministic; the points are others than those that a tree was built with.
/// @param samples  points of the surface, and as many in the box for the volume.
UnionError MeasureUnion(const TriangleMesh& mesh, const std::vector<Sphere>& balls,
                        std::size_t samples = 100003);

/// The balls of each level of a tree, coarsest first; the last are its leaves.  The others bound
/// what is below them.
std::vector<std::vector<Sphere>> BallsByLevel(const SphereTree& tree);

/// MeasureUnion of each level, against the solid that the mesh stands for (mesh_solid.h).
std::vector<UnionError> MeasureLevels(const TriangleMesh& mesh, const SphereTree& tree,
                                      std::size_t samples = 100003);

}  // namespace palpate
