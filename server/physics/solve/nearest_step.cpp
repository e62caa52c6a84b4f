#include "server/physics/solve/nearest_step.h"

#include "server/physics/solve/qp_solver.h"

namespace palpate {

Optimum NearestStep(const StepContext& context, const Target& target,
                    std::span<Energy* const> energies) noexcept {
  Optimum optimum;
  const ContactRows& rows = context.buffers.rows;
  const double rho = context.model.rotation_length();
  int guess[kMaxActiveRows];
  const int guesses = rows.Find(context.state.active_pairs.data(), context.state.active, guess);
  const double t[6] = {target.v.x(),         target.v.y(),         target.v.z(),
                       rho * target.phi.x(), rho * target.phi.y(), rho * target.phi.z()};
  const auto solve = [&]<int N>() {
    // From where the tool is: what overlaps there mostly does so after the step too.
    constexpr double start[6] = {};
    return energies.empty()
               ? SolveNearestPoint<N>(context.kernels, t, context.rigid, guess, guesses)
               : context.buffers.energies->Solve(context.kernels, N, t, context.rigid, energies,
                                                 start, {guess, static_cast<std::size_t>(guesses)});
  };
  if (context.model.degrees_of_freedom() == 6) {
    optimum.qp = solve.operator()<6>();
    const double* x = optimum.qp.x;
    optimum.phi = Vec3(x[3], x[4], x[5]) / rho;
  } else {
    optimum.qp = solve.operator()<3>();
    optimum.phi = target.phi;
  }
  optimum.v = Vec3(optimum.qp.x[0], optimum.qp.x[1], optimum.qp.x[2]);
  optimum.RefuseNaN();
  return optimum;
}

void Remember(const StepContext& context, const Optimum& optimum) noexcept {
  const QpResult& qp = optimum.qp;
  context.state.active = qp.active;
  for (int i = 0; i < qp.active; ++i) {
    context.state.active_pairs[static_cast<std::size_t>(i)] = context.buffers.rows.pair(qp.row[i]);
  }
}

}  // namespace palpate
