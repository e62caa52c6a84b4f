#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "scenes/scene.h"
#include "scenes/tree/sphere_tree_builder.h"
#include "scenes/tree/tree_source.h"
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

/// Errors of the forces felt on a sliding path, (2.36): delta = (F_gm - F_tm) / |F_gm|, gm the
/// truth.
struct ForceErrors {
  std::vector<double> x, y;    ///< delta of each steady sample, as the chapter plots it
  MeanMax axis[3], magnitude;  ///< |delta_x|, |delta_y|, |delta_z|; |delta|
  MeanMax strength;            ///< ||F_tm| - |F_gm|| / |F_gm|: what the JND of 6-8 % is about
  MeanMax direction_deg;

  ForceErrors(const SlidingPath& path, const std::vector<Vec3>& forces);
};

/// Which object the ball slides over, and how it is stepped.
struct SlidingExperiment {
  std::string object = "cube";    ///< or ellipsoid
  std::size_t triangles = 20480;  ///< of the ellipsoid's mesh, at least
  /// How truly that mesh stands for the ellipsoid (scenes/mesh/curved_mesh.h) where the contact is
  /// of surfaces [m]; 0: its triangles are taken as they are.
  double tolerance = 3e-6;
  Features features{.contact = ContactModel::kSpheres};
  TreeSource tree{};  ///< of the object; a file's numbers are metres where it has no unit
  int steps = 4000;   ///< of steady sliding
  int repeats = 5;

  bool cube() const { return object == "cube"; }
};
SlidingPath PathOf(const SlidingExperiment& experiment);
/// As made, not refined.
TriangleMesh ObjectMesh(const SlidingExperiment& experiment, std::size_t triangles);
/// Ball and object; the object's tree has so many leaves, or those of its file.
Scene SlidingScene(const SlidingExperiment& experiment, std::size_t spheres);

struct SlidingForce {
  std::size_t spheres = 0, triangles = 0;  ///< of the object
  std::size_t felt_triangles = 0;          ///< what those are refined into
  ForceErrors errors;
  MeanMax truncation_um;
  BestOf step_us;
};
/// Throws Error where the physics has not the features.
SlidingForce MeasureSlidingForce(const SlidingExperiment& experiment, std::size_t spheres);

}  // namespace palpate::bench
