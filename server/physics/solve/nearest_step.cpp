#include "server/physics/limits.h"
#include "server/physics/solve/stages.h"

namespace palpate {

Optimum NearestStep(StepContext& context, const Target& target, bool with_energies) noexcept {
  Optimum optimum;
  const ContactRows& rows = context.buffers().rows;
  const double rho = context.model.rotation_length();
  int guess[kMaxActiveRows];
  const int guesses = rows.Find(context.sub_step.active, guess);
  Vec6 t;
  t << target.v, rho * target.phi;
  if (with_energies) {
    // Drag of the last steps: it depends on the rows' push, so it is not an energy's force.
    const Vec6& drag = context.state().cut.drag;
    t += drag;
    optimum.qp =
        context.buffers().energies->Solve(context.kernels, t.data(), context.sub_step.rigid,
                                          {guess, static_cast<std::size_t>(guesses)});
    const Vec6 force = context.buffers().energies->force();
    optimum.is_pushed = context.buffers().energies->pushes();
    optimum.push = force.head<3>() + drag.head<3>();
    optimum.push_torque = rho * force.tail<3>() + rho * drag.tail<3>();
  } else {
    optimum.qp = context.kernels.solve(t.data(), context.sub_step.rigid, guess, guesses);
  }
  optimum.Take(rho);
  return optimum;
}

bool RoundCreases(StepContext& context, Optimum& optimum) noexcept {
  const QpResult& qp = optimum.qp;
  if (qp.status != QpStatus::kSolved) return false;
  Mat3 bend = Mat3::Zero();      // sum l_i K_i
  Mat3 free = Mat3::Identity();  // projects onto the motions that no active row stops
  double most = 0.0;             // upper bound on the norm of `bend`
  for (int i = 0; i < qp.active; ++i) {
    Mat3 curvature = Mat3::Zero();  // of the frame to which the row belongs, and zero of the others
    for (const MeshContact& contact : context.buffers().meshes->of) {
      const Mat3& R = contact.moved.R_v();
      const Mat3 in_B = CurvatureOf(contact, qp.row[i]);
      curvature += contact.moved.is_W() ? in_B : Mat3(R * in_B * R.transpose());
    }
    bend += qp.multiplier[i] * curvature;
    // The curvature is a projector over the distance to the edge, so its trace over its square's
    // trace is that distance.
    const double trace = curvature.trace();
    if (trace > 0.0) most += qp.multiplier[i] * curvature.squaredNorm() / trace;
    const Vec3 stopped = free * context.buffers().rows.normal(qp.row[i]);
    if (stopped.squaredNorm() > limits::mesh::kLeastFree)
      free -= stopped * stopped.transpose() / stopped.squaredNorm();
  }
  if (most == 0.0) return false;
  // A hand on the edge itself has no nearest place; it is treated as slightly outside.
  if (most > limits::mesh::kMostBend) bend *= limits::mesh::kMostBend / most;
  const Vec3 straight = optimum.v;
  const Vec3 beyond =
      (Mat3::Identity() - free * bend * free).inverse() * (free * (bend * straight));
  Target target = context.sub_step.target;
  target.v += bend * (straight + beyond);
  optimum = NearestStep(context, target);
  return true;
}

void Remember(StepContext& context, const Optimum& optimum) noexcept {
  const ContactRows& rows = context.buffers().rows;
  ActiveIds& active = context.sub_step.active;
  active.count = 0;
  for (const int row : optimum.qp.ActiveRows()) {
    if (!rows.IsLoose(row)) active.id[static_cast<std::size_t>(active.count++)] = rows.id(row);
  }
}

}  // namespace palpate
