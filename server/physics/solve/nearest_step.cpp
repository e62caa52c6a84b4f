#include "server/physics/solve/nearest_step.h"

#include "server/physics/solve/qp_solver.h"

namespace palpate {

Optimum NearestStep(const StepContext& context, const Target& target, bool with_energies) noexcept {
  Optimum optimum;
  const ContactRows& rows = context.buffers.rows;
  const double rho = context.model.rotation_length();
  int guess[kMaxActiveRows];
  const int guesses = rows.Find(context.state.Active(), guess);
  const double t[6] = {target.v.x(),         target.v.y(),         target.v.z(),
                       rho * target.phi.x(), rho * target.phi.y(), rho * target.phi.z()};
  const bool turns = context.model.degrees_of_freedom() == 6;
  if (with_energies) {
    optimum.qp = context.buffers.energies->Solve(context.kernels, t, context.sub_step.rigid,
                                                 {guess, static_cast<std::size_t>(guesses)});
    const double* force = context.buffers.energies->force();
    optimum.is_pushed = context.buffers.energies->pushes();
    optimum.push = Vec3(force[0], force[1], force[2]);
    optimum.push_turn = rho * Vec3(force[3], force[4], force[5]);
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
