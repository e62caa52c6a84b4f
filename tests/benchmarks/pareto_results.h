#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tests/benchmarks/figures.h"
#include "tests/benchmarks/machine.h"
#include "tests/benchmarks/sliding_force.h"

namespace palpate::bench {

// What palpate-bench pareto has measured.  Whatever was not reached is empty.

/// Time of a step [us].
struct Speed {
  Percentiles best, raw;
  /// False where repeats ended differently: `best` is then of single runs, the same as `raw`.
  bool repeatable = true;
};

/// What a path's steps were right by, on every n-th of them.
struct PathError {
  Percentiles penetration_um;  ///< of the meshes, by MeshOracle
  /// Mean force where the hand's own pose is free: what holds it there is not the objects, unless
  /// the tool is caught behind them.
  double free_force_N = 0.0;
  double force_rms_N = 0.0;   ///< of all steps
  double force_jump_N = 0.0;  ///< greatest change from one step to the next, of all steps
};

/// One way of stepping: its speed and its errors, or why there are none.
struct Measured {
  std::string not_available{};  ///< the reason; empty where it was measured
  Speed speed{};
  std::optional<MeanMax> slide{};  ///< |delta F| of (2.36), the experiment of chapter 2.5.1
  std::optional<PathError> path{};
};

/// Palpate with one choice of models.
struct ModelRun : Measured {
  std::string contact{}, friction{};
  std::optional<double> sphere_overlap_um{};  ///< deepest, of the spheres; sphere contact only
};

struct SceneResult {
  std::string scene;
  std::string not_available{};
  std::size_t tool_spheres = 0, object_spheres = 0, triangles = 0, steps = 0;
  bool yields = false;  ///< objects are soft: a part of the penetration is meant
  std::vector<ModelRun> runs{};
};

/// Meshes of the ellipsoid that goals are set for, beside the experiment's own.
inline constexpr std::size_t kFewTriangles = 5120, kManyTriangles = 81920;

/// The experiment of chapter 2.5.1 at one count of spheres.
struct SlideResult : ModelRun {
  std::string object{};  ///< cube or ellipsoid
  std::size_t spheres = 0, triangles = 0;
};

/// One feature of the step beside the step without any, on the same path.
struct FeatureCost : Measured {
  std::string feature{};
  double ratio_p50 = 0.0, ratio_p999 = 0.0;
};

struct PeerRun : Measured {
  std::string id{};      ///< of PeerKind; empty: Palpate
  std::string name{};    ///< with what sets it apart, as "Bullet, 4 sub-steps"
  std::string object{};  ///< of a slide: cube or ellipsoid
};

struct ParetoResults {
  std::string command;
  bool quick = false, complete = false;
  bool only_peers = false;
  Machine machine;
  std::vector<SlideResult> slides;
  std::vector<SceneResult> scenes;
  std::string feature_scene;
  std::vector<FeatureCost> features;
  std::vector<std::string> peers_asked;  ///< ids
  std::string peer_scene;
  std::size_t peer_steps = 0;
  std::vector<PeerRun> peer_path, peer_slide, peer_variants;
};

}  // namespace palpate::bench
