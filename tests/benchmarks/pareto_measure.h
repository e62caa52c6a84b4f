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

/// Thrown out of a measurement when Ctrl-C ends it.
struct Stopped {};

/// Judges where a path's steps ended, by the meshes alone: the same judge for Palpate and peers.
class PathJudge {
 public:
  /// @param checks  about how many of the steps are looked at.
  /// `scene` and `stop` must outlive this.
  PathJudge(const Scene& scene, std::span<const Pose> X_WH, int checks, const StopSignal& stop);

  /// Of as many poses and forces as the path has steps.  Throws Stopped.
  PathError Judge(std::span<const Pose> X_WG, std::span<const Vec3> force) const;

  std::size_t every() const { return every_; }

 private:
  test::MeshOracle oracle_;
  const StopSignal& stop_;
  std::size_t every_;
  std::vector<bool> hand_is_free_;  ///< at the steps that are checked
};

/// `repeats` passes over the run's path.  Throws Stopped.
struct TimedRun {
  Speed speed;
  std::vector<StepReport> steps;
};
TimedRun TimeRun(SceneRun& run, int repeats, const StopSignal& stop);

/// A scene as peers take it; it must outlive them.
PeerScene ForPeers(const Scene& scene);

/// `repeats` new peers over the path; what they did is of the first one.  Throws Error, Stopped.
struct TimedPeer {
  Speed speed;
  std::vector<PeerStep> steps;
};
TimedPeer TimePeer(const PeerKind& kind, const PeerScene& scene, std::span<const Pose> X_WH,
                   const PeerSettings& settings, int repeats, const StopSignal& stop);

}  // namespace palpate::bench
