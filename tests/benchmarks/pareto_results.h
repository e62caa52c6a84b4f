#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "tests/benchmarks/figures.h"
#include "tests/benchmarks/machine.h"
#include "tests/benchmarks/peers/peer.h"
#include "tests/benchmarks/sliding_force.h"

namespace palpate::bench {

// The measurements of palpate-bench pareto.  Those not yet made are empty.

/// Time of a step [us].
struct Speed {
  Percentiles best, raw;
  /// False if repeats gave different results: `best` is then that of single runs, as `raw`.
  bool repeatable = true;
};

/// The errors of a path's steps, at every n-th step.
struct PathError {
  Percentiles penetration_um;  ///< of the meshes, by MeshOracle
  /// Mean force at steps at which the hand's own pose is free.  The objects cause none there,
  /// unless the tool is caught behind them.
  double free_force_N = 0.0;
  double force_rms_N = 0.0;   ///< of all steps
  double force_jump_N = 0.0;  ///< greatest change from one step to the next, of all steps
};

/// One method of stepping: its speed and errors, or the reason why there are none.
struct Measured {
  std::string not_available{};  ///< the reason; empty if it was measured
  Speed speed{};
  std::optional<MeanMax> slide{};  ///< |delta F| of (2.36), the experiment of chapter 2.5.1
  std::optional<PathError> path{};
};

/// Palpate with one choice of models.
struct ModelRun : Measured {
  std::string contact{}, friction{};
  std::optional<double> sphere_overlap_um{};  ///< deepest; only with sphere contact
};

struct SceneResult {
  std::string scene;
  std::string not_available{};
  std::size_t tool_spheres = 0, object_spheres = 0, triangles = 0, steps = 0;
  bool yields = false;  ///< objects are soft, so part of the penetration is intended
  std::vector<ModelRun> runs{};
};

/// Further meshes of the ellipsoid, for which there are goals.
inline constexpr std::size_t kFewTriangles = 5120, kManyTriangles = 81920;

/// The experiment of chapter 2.5.1 at one count of spheres.
struct SlideResult : ModelRun {
  std::string object{};  ///< cube or ellipsoid
  std::size_t spheres = 0, triangles = 0;
};

struct PeerRun : Measured {
  std::string id{};      ///< PeerKind::id; empty: Palpate
  std::string name{};    ///< with its settings, as "Bullet, 4 sub-steps"
  std::string object{};  ///< for a slide: cube or ellipsoid
};

struct ParetoResults {
  std::string command;
  bool quick = false, complete = false;
  bool only_peers = false;
  Machine machine;
  std::vector<SlideResult> slides;
  std::vector<SceneResult> scenes;
  std::vector<PeerKind> peers_known;     ///< those of PeerKinds(), then those of --peers FILE
  std::vector<std::string> peers_asked;  ///< ids
  std::string peer_scene;
  std::size_t peer_steps = 0;
  std::vector<PeerRun> peer_path, peer_slide;
};

}  // namespace palpate::bench
