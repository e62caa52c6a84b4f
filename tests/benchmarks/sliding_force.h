#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "scenes/scene.h"
#include "scenes/tree/sphere_tree_builder.h"
#include "tests/benchmarks/figures.h"
#include "tests/benchmarks/sliding_path.h"

namespace palpate::bench {

struct MeanMax {
  double mean = 0.0, max = 0.0, mean_square = 0.0;
  void Add(double value, std::size_t of) {
    mean += value / static_cast<double>(of);
    max = std::max(max, value);
    mean_square += value * value / static_cast<double>(of);
  }
  double rms() const { return std::sqrt(mean_square); }
};

/// Errors of the forces on a sliding path (2.36): delta = (F_gm - F_tm) / |F_gm|, F_gm being true.
struct ForceErrors {
  std::vector<double> x, y;    ///< delta of each steady sample, as in the chapter's plots
  MeanMax axis[3], magnitude;  ///< |delta_x|, |delta_y|, |delta_z|; |delta|
  MeanMax strength;            ///< ||F_tm| - |F_gm|| / |F_gm|: to be compared with the JND of 6-8 %
  MeanMax direction_deg;

  ForceErrors(const SlidingPath& path, const std::vector<Vec3>& forces);
};

/// The object over which the ball slides, and the settings of the step.
struct SlidingExperiment {
  std::string object = "cube";    ///< or ellipsoid
  std::size_t triangles = 20480;  ///< of the ellipsoid's mesh, at least
  /// Tolerance with which the refined mesh approximates the ellipsoid (scenes/mesh/curved_mesh.h),
  /// for contact of surfaces [m]; 0: the triangles are not refined.
  double tolerance = 3e-6;
  Features features{.contact = ContactModel::kSpheres};
  TreeMode tree = TreeMode::kInside;  ///< of the object
  int steps = 4000;                   ///< number of steps of steady sliding
  int repeats = 5;

  bool cube() const { return object == "cube"; }
};
SlidingPath PathOf(const SlidingExperiment& experiment);
/// Makes the object's mesh, without refinement.
TriangleMesh ObjectMesh(const SlidingExperiment& experiment, std::size_t triangles);
/// Makes the scene of ball and object, whose tree has `spheres` leaves.
Scene SlidingScene(const SlidingExperiment& experiment, std::size_t spheres);

struct SlidingForce {
  std::size_t spheres = 0, triangles = 0;  ///< of the object
  std::size_t felt_triangles = 0;          ///< number after refinement
  ForceErrors errors;
  MeanMax truncation_um;
  BestOf step_us;
};
/// Throws Error if the physics lacks the requested features.
SlidingForce MeasureSlidingForce(const SlidingExperiment& experiment, std::size_t spheres);

}  // namespace palpate::bench
