#include "server/physics/solve/nearest_step.h"

#include "server/physics/solve/qp_solver.h"

namespace palpate {

Optimum NearestStep(const StepContext& context, const Target& target, bool with_energies) noexcept {
  Optimum optimum;
  const ContactRows& rows = context.buffers.rows;
  const double rho = context.model.rotation_length();
  int guess[kMaxActiveRows];
  const int guesses = rows.Find(context.state.Active(), guess);
  double t[6] = {target.v.x(),         target.v.y(),         target.v.z(),
                 rho * target.phi.x(), rho * target.phi.y(), rho * target.phi.z()};
  const bool turns = context.model.degrees_of_freedom() == 6;
  if (with_energies) {
    const std::array<double, 6>& drag = context.state.drag;
    // Of the last steps: a force that goes with what the rows push is no energy's.
    const bool dragged = drag != std::array<double, 6>{};
    for (std::size_t c = 0; dragged && c < 6; ++c) t[c] += drag[c];
    optimum.qp = context.buffers.energies->Solve(context.kernels, t, context.sub_step.rigid,
                                                 {guess, static_cast<std::size_t>(guesses)});
    const double* force = context.buffers.energies->force();
    optimum.is_pushed = context.buffers.energies->pushes();
    optimum.push = Vec3(force[0], force[1], force[2]);
    optimum.push_turn = rho * Vec3(force[3], force[4], force[5]);
    if (dragged) {
      optimum.push += Vec3(drag[0], drag[1], drag[2]);
      optimum.push_turn += rho * Vec3(drag[3], drag[4], drag[5]);
    }
  } else {
    optimum.qp = (turns ? SolveNearestPoint<6> : SolveNearestPoint<3>)(context.kernels, t,
                                                                       context.sub_step.rigid,
                                                                       guess, guesses);
  }
  const double* x = optimum.qp.x;
  optimum.phi = turns ? Vec3(Vec3(x[3], x[4], x[5]) / rho) : target.phi;
  optimum.v = Vec3(optimum.qp.x[0], optimum.qp.x[1], optimum.qp.x[2]);
  optimum.RefuseNaN();
  return optimum;
}

void Remember(const StepContext& context, const Optimum& optimum) noexcept {
  const QpResult& qp = optimum.qp;
  context.state.active = qp.active;
  for (int i = 0; i < qp.active; ++i) {
    context.state.active_ids[static_cast<std::size_t>(i)] = context.buffers.rows.id(qp.row[i]);
  }
}

}  // namespace palpate
