#include <memory>

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

namespace {

const ContactRows::Other* OtherOf(const ContactRows& rows, int row) {
  return rows.with_others() && rows.other(row).tool >= 0 ? &rows.other(row) : nullptr;
}

/// Writes the rows of all tools side by side: a row a . x_i + a' . x_j >= b has a / sqrt(w_i) in
/// the columns of i, and a' / sqrt(w_j) in those of j; bodies' as their metric says.  The last
/// column is b.  The limits of joints come last.
/// @param first  the first row of each tool
template <int N>
QpRowsOf<N> PutTogether(Party tools, int* first) {
  AlignedColumns& columns = Lead(tools).together->columns;
  const auto clear = [&](int row) {
    for (std::size_t c = 0; c < N; ++c) columns[c][row] = 0.0;
  };
  const auto put = [&](std::size_t i, const Vec6& of_unknowns, double offset, int row) {
    for (std::size_t c = 0; c < 6; ++c) columns[6 * i + c][row] = of_unknowns[Eigen::Index(c)];
    columns[N][row] -= offset;
  };
  int at = 0;
  for (std::size_t i = 0; i < tools.size(); ++i) {
    const ContactRows& rows = tools[i]->buffers().rows;
    const QpRows& own = tools[i]->sub_step.rigid;
    first[i] = at;
    for (int r = 0; r < own.count; ++r, ++at) {
      clear(at);
      columns[N][at] = own.b[r];
      Vec6 a;
      for (Eigen::Index c = 0; c < 6; ++c) a[c] = own.a[c][r];
      put(i, tools[i]->RowOfUnknowns(a), tools[i]->OffsetOf(a), at);
      const ContactRows::Other* other = OtherOf(rows, r);
      if (other == nullptr) continue;
      const auto j = static_cast<std::size_t>(other->tool);
      a << other->v, other->phi / tools[j]->model.rotation_length();
      put(j, tools[j]->RowOfUnknowns(other->v, other->phi), tools[j]->OffsetOf(a), at);
    }
  }
  first[tools.size()] = at;
  for (std::size_t i = 0; i < tools.size(); ++i) {
    for (int k = 0; tools[i]->metric && k < tools[i]->metric->limits; ++k, ++at) {
      clear(at);
      columns[N][at] = tools[i]->metric->bound[k];
      const Vec6& a = tools[i]->metric->limit[k];
      put(i, tools[i]->RowOfUnknowns(a), tools[i]->OffsetOf(a), at);
    }
  }
  Lead(tools).together->rows = at;
  QpRowsOf<N> all{{}, columns[N], at};
  for (std::size_t c = 0; c < N; ++c) all.a[c] = columns[c];
  for (; at % 16 != 0; ++at) {
    clear(at);
    columns[N][at] = -1e300;
  }
  return all;
}

template <int N>
void SolveTogether(Party tools, const double* t, std::span<const ToolRow> guess,
                   QpResultOf<N> (*solve)(const double*, const QpRowsOf<N>&, const int*, int)) {
  int first[kMostMembers + 1], guessed[N + 1], guesses = 0;
  const QpRowsOf<N> rows = PutTogether<N>(tools, first);
  for (const ToolRow& row : guess) {
    if (guesses <= N) guessed[guesses++] = first[row.tool] + row.row;
  }
  const QpResultOf<N> qp = solve(t, rows, guessed, guesses);
  for (std::size_t i = 0; i < tools.size(); ++i) {
    std::construct_at(&tools[i]->nearest);
    QpResult& of_tool = tools[i]->nearest.qp;
    Vec6::Map(of_tool.x) = tools[i]->FromUnknowns(Vec6::Map(qp.x + 6 * i));
    of_tool.slack = qp.slack;
    of_tool.iterations = qp.iterations;
    of_tool.status = qp.status;
  }
  for (int k = 0; k < qp.active; ++k) {
    std::size_t i = 0;
    if (int limit = qp.row[k] - first[tools.size()]; limit >= 0) {
      while (!tools[i]->metric || limit >= tools[i]->metric->limits) {
        limit -= tools[i]->metric ? tools[i]->metric->limits : 0;
        ++i;
      }
      tools[i]->nearest.is_touched = true;  // by its joint's limit
      continue;
    }
    while (qp.row[k] >= first[i + 1]) ++i;
    const int row = qp.row[k] - first[i];
    if (const auto* other = OtherOf(tools[i]->buffers().rows, row); other != nullptr) {
      tools[static_cast<std::size_t>(other->tool)]->nearest.is_touched = true;
    }
    QpResult& of_tool = tools[i]->nearest.qp;
    if (of_tool.active == kMaxActiveRows) continue;  // its force counts in x
    of_tool.row[of_tool.active] = row;
    of_tool.multiplier[of_tool.active++] = qp.multiplier[k] / tools[i]->weight;
  }
}

}  // namespace

void SolveRows(Party tools, const double* t, std::span<const ToolRow> guess) noexcept {
  StepContext& lead = Lead(tools);
  if (lead.together == nullptr) {
    int rows[kMaxActiveRows], guesses = 0;
    for (const ToolRow& row : guess) rows[guesses++] = row.row;
    lead.nearest.qp = lead.kernels.solve(t, lead.sub_step.rigid, rows, guesses);
  } else if (tools.size() <= 2) {
    SolveTogether(tools, t, guess, lead.kernels.solve_two);
  } else if (tools.size() <= 4) {
    SolveTogether(tools, t, guess, lead.kernels.solve_four);
  } else {
    SolveTogether(tools, t, guess, lead.kernels.solve_eight);
  }
}

bool RowsHold(Party tools, const double* x, double tolerance) noexcept {
  const StepContext& lead = Lead(tools);
  if (lead.together == nullptr) return lead.kernels.rows_hold(lead.sub_step.rigid, x, tolerance);
  const AlignedColumns& columns = lead.together->columns;
  const std::size_t n = Together::UnknownsOf(tools.size());
  for (int r = 0; r < lead.together->rows; ++r) {
    double left = -columns[n][r];
    for (std::size_t c = 0; c < n; ++c) left += columns[c][r] * x[c];
    if (left < -tolerance) return false;
  }
  return true;
}

void NearestSteps(Party tools, bool with_energies) noexcept {
  StepContext& lead = Lead(tools);
  if (lead.together == nullptr) {
    lead.nearest = NearestStep(lead, lead.goal, with_energies);
    return;
  }
  double t[6 * kMostMembers] = {};
  ToolRow guess[kMaxActiveRows * kMostMembers];
  std::size_t guesses = 0;
  for (std::size_t i = 0; i < tools.size(); ++i) {
    const StepContext& tool = *tools[i];
    Vec6::Map(t + 6 * i) = tool.ToUnknowns(tool.goal.v, tool.goal.phi);
    int found[kMaxActiveRows];
    const int count = tool.buffers().rows.Find(tool.sub_step.active, found);
    for (int k = 0; k < count; ++k) guess[guesses++] = {i, found[k]};
  }
  SolveRows(tools, t, {guess, guesses});
  for (StepContext* tool : tools) tool->nearest.Take(tool->model.rotation_length());
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
