#include "tests/benchmarks/pareto_measure.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include <spdlog/fmt/fmt.h>

#include "common/error.h"

namespace palpate::bench {
namespace {

void ThrowIfStopped(const StopSignal& stop) {
  if (stop.stopped()) throw Stopped{};
}

bool SameBits(const Pose& a, const Pose& b) {
  return a.p == b.p && a.q.coeffs() == b.q.coeffs();
}

}  // namespace

PathJudge::PathJudge(const Scene& scene, std::span<const Pose> X_WH, int checks,
                     const StopSignal& stop)
    : oracle_(scene),
      stop_(stop),
      every_(std::max<std::size_t>(1, X_WH.size() / static_cast<std::size_t>(checks))) {
  for (std::size_t i = 0; i < X_WH.size(); i += every_) {
    ThrowIfStopped(stop_);
    hand_is_free_.push_back(!oracle_.Meet(X_WH[i]));
  }
}

PathError PathJudge::Judge(std::span<const Pose> X_WG, std::span<const Vec3> force) const {
  PathError error;
  std::vector<double> depth_um;
  int free = 0;
  for (std::size_t i = 0; i < X_WG.size(); ++i) {
    error.force_rms_N += force[i].squaredNorm() / static_cast<double>(X_WG.size());
    if (i > 0) error.force_jump_N = std::max(error.force_jump_N, (force[i] - force[i - 1]).norm());
    if (i % every_ != 0) continue;
    ThrowIfStopped(stop_);
    depth_um.push_back(1e6 * oracle_.At(X_WG[i]).depth);
    if (!hand_is_free_[i / every_]) continue;
    error.free_force_N += force[i].norm();
    ++free;
  }
  if (free > 0) error.free_force_N /= free;
  error.force_rms_N = std::sqrt(error.force_rms_N);
  error.penetration_um = PercentilesOf(std::move(depth_um));
  return error;
}

TimedRun TimeRun(SceneRun& run, int repeats, const StopSignal& stop) {
  TimedRun timed;
  BestOf best;
  for (int r = 0; r < repeats; ++r) {
    ThrowIfStopped(stop);
    best.Add(run.Time(r == 0 ? &timed.steps : nullptr));
  }
  timed.speed = {PercentilesOf(best.best()), PercentilesOf(best.all())};
  return timed;
}

PeerScene ForPeers(const Scene& scene) {
  const Body& tool = scene.tools.front();
  PeerScene peers{.tool = &tool.mesh, .centroid = tool.tree.centroid, .coupling = scene.coupling};
  if (tool.tree.leaves() == 1) peers.ball = tool.tree.leaf_radius.front();
  for (const Body& object : scene.objects) peers.objects.push_back({&object.mesh, object.X_WB});
  return peers;
}

TimedPeer TimePeer(const PeerKind& kind, const PeerScene& scene, std::span<const Pose> X_WH,
                   int repeats, const StopSignal& stop) {
  using Clock = std::chrono::steady_clock;
  TimedPeer timed;
  BestOf best;
  for (int r = 0; r < repeats; ++r) {
    const std::unique_ptr<Peer> peer = kind.make(scene, X_WH.front());
    std::vector<double> step_us;
    std::vector<PeerStep> steps;
    step_us.reserve(X_WH.size());
    steps.reserve(X_WH.size());
    for (const Pose& X : X_WH) {
      ThrowIfStopped(stop);
      const auto begin = Clock::now();
      steps.push_back(peer->Step(X));
      const auto end = Clock::now();
      step_us.push_back(std::chrono::duration<double, std::micro>(end - begin).count());
      if (!steps.back().X_WG.p.allFinite()) {
        throw Error(fmt::format("its tool is nowhere after step {}", steps.size()));
      }
    }
    best.Add(step_us);
    if (r == 0) {
      timed.steps = std::move(steps);
    } else {
      timed.speed.repeatable &=
          std::equal(steps.begin(), steps.end(), timed.steps.begin(),
                     [](const PeerStep& a, const PeerStep& b) { return SameBits(a.X_WG, b.X_WG); });
    }
  }
  timed.speed.raw = PercentilesOf(best.all());
  timed.speed.best = timed.speed.repeatable ? PercentilesOf(best.best()) : timed.speed.raw;
  return timed;
}

}  // namespace palpate::bench
