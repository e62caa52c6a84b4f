#include "server/physics/solve/round_creases.h"

#include "server/physics/contact/reconcile.h"
#include "server/physics/limits.h"
#include "server/physics/solve/nearest_step.h"

namespace palpate {

bool RoundCreases(const StepContext& context, Optimum& optimum) noexcept {
  const QpResult& qp = optimum.qp;
  if (qp.status != QpStatus::kSolved) return false;
  Mat3 bend = Mat3::Zero();      // sum l_i K_i
  Mat3 free = Mat3::Identity();  // projects onto the ways that no active row stops
  double most = 0.0;             // bounds the bend's norm
  for (int i = 0; i < qp.active; ++i) {
    const Mat3 curvature = CurvatureOf(*context.buffers.meshes, qp.row[i]);
    bend += qp.multiplier[i] * curvature;
    // A projector over the distance to the edge: its trace over its square's is that distance.
    const double trace = curvature.trace();
    if (trace > 0.0) most += qp.multiplier[i] * curvature.squaredNorm() / trace;
    const Vec3 stopped = free * context.buffers.rows.normal(qp.row[i]);
    if (stopped.squaredNorm() > limits::mesh::kLeastFree)
      free -= stopped * stopped.transpose() / stopped.squaredNorm();
  }
  if (most == 0.0) return false;
  // A hand on the edge itself has no nearest place: it is taken to be a little outside.
  if (most > limits::mesh::kMostBend) bend *= limits::mesh::kMostBend / most;
  const Vec3 straight = optimum.v;
  const Vec3 beyond =
      (Mat3::Identity() - free * bend * free).inverse() * (free * (bend * straight));
  Target target = context.sub_step.target;
  target.v += bend * (straight + beyond);
  optimum = NearestStep(context, target);
  return true;
}

}  // namespace palpate
