#pragma once

#include <memory>
#include <span>
#include <vector>

#include "common/program/stop_signal.h"
#include "scenes/scene.h"
#include "tests/benchmarks/pareto_results.h"
#include "tests/benchmarks/peers/peer.h"
#include "tests/benchmarks/scene_run.h"
#include "tests/support/mesh_oracle.h"

namespace palpate::bench {

/// Thrown when Ctrl-C ends a measurement.
struct Stopped {};

/// Judges the resulting poses of a path from the meshes alone; the same for Palpate and its peers.
class PathJudge {
 public:
  /// @param checks  approximate number of steps to check.
  /// `scene` and `stop` must outlive this.
  PathJudge(const Scene& scene, std::span<const Pose> X_WH, int checks, const StopSignal& stop);

  /// Judges one pose and force per step of the path.  Throws Stopped.
  PathError Judge(std::span<const Pose> X_WG, std::span<const Vec3> force) const;

  std::size_t every() const { return every_; }

 private:
  test::MeshOracle oracle_;
  const StopSignal& stop_;
  std::size_t every_;
  std::vector<bool> hand_is_free_;  ///< at the checked steps
};

/// The result of `repeats` passes over the run's path.  Throws Stopped.
struct TimedRun {
  Speed speed;
  std::vector<StepReport> steps;
};
TimedRun TimeRun(SceneRun& run, int repeats, const StopSignal& stop);

/// Converts a scene for peers; it must outlive them.
PeerScene ForPeers(const Scene& scene);

/// The result of `repeats` new peers over the path; steps of the first.  Throws Error, Stopped.
struct TimedPeer {
  Speed speed;
  std::vector<PeerStep> steps;
};
TimedPeer TimePeer(const PeerKind& kind, const PeerScene& scene, std::span<const Pose> X_WH,
                   int repeats, const StopSignal& stop);

}  // namespace palpate::bench
