#include <algorithm>
#include <cmath>
#include <utility>

#include "common/math/rotation.h"
#include "server/physics/energy/energy.h"
#include "server/physics/limits.h"
#include "server/physics/solve/stages.h"

namespace palpate {
namespace {

using namespace limits::friction;

using Vec2 = Eigen::Vector2d;
template <int N>
using Vec = Eigen::Matrix<double, N, 1>;
template <int N>
using Mat = Eigen::Matrix<double, N, N>;
template <int N>
using Mat3N = Eigen::Matrix<double, 3, N, Eigen::RowMajor>;
double Largest(const auto& v) {
  return v.template lpNorm<Eigen::Infinity>();
}

double MultiplierOf(const QpResult& qp, int row) {
  const int* found = std::find(qp.row, qp.row + qp.active, row);
  return found == qp.row + qp.active ? 0.0 : qp.multiplier[found - qp.row];
}

/// Solves H x = g by elimination with row exchanges; Eigen's takes twice as long at this size.
template <int N>
Vec<N> SolveLinear(const Mat<N>& H, const Vec<N>& g) {
  Eigen::Matrix<double, N, N + 2, Eigen::RowMajor> A;  // an even width, for vectors
  A << H, g, g;
  for (int k = 0; k < N; ++k) {
    int pivot;
    A.col(k).tail(N - k).cwiseAbs().maxCoeff(&pivot);
    A.row(k).swap(A.row(k + pivot));
    for (int i = k + 1; i < N; ++i) A.row(i) -= A(i, k) / A(k, k) * A.row(k);
  }
  const auto upper = A.template leftCols<N>().template triangularView<Eigen::Upper>();
  return upper.solve(A.col(N));
}

/// A contact that yields: it pushes back by its stiffness times its offset, within Coulomb's law.
/// Its axes are -n and two tangents.
template <int N>
struct Contact {
  ToolRow of;
  int other = -1;           ///< the other tool that its row names; negative: none
  Mat3 axes;                ///< row by row, in W
  Vec3 lever, other_lever;  ///< of its point, from either tool's reference point
  const FrameMotion* body;  ///< how what it touches moves; null if it stands, or is a tool
  Mat3N<N> J;               ///< its motion along the axes, over x
  Vec3 still;               ///< its offset where the tool stays: b of its row a . x >= b, and the
                            ///< slip of a body that moves
  double mu, mu_s, mu_d;    ///< mu is one of the two
  Vec3 f;                   ///< (lambda, friction), against the motion: the tool feels -J^T f
  Vec3 held;                ///< f where the offset is none
  Vec3 offset;              ///< (b - a . x, slip)
  Vec3 law;                 ///< what f must be
  double ratio;             ///< of friction's limit to what it would be without; 1 if it sticks
  Vec2 direction;           ///< of friction, if it slips
  Vec3 mean, moved;         ///< f = mean + rate dx, and by how much that changes it in a step
  Mat3N<N> rate;
  Vec3 start, before;  ///< f and `held` to go back to

  double lambda() const { return f[0]; }
  auto friction() { return f.template tail<2>(); }
  auto friction() const { return f.template tail<2>(); }
  bool slips() const { return ratio < 1.0; }
  double slip() const { return offset.tail<2>().norm(); }

  /// Evaluates the law at x and f, with w = r (offset - (f - held) / k) for any r > 0:
  ///   lambda = max(0, lambda + w_1),
  ///   friction = friction + w_2,3, projected onto the disk of radius mu lambda.
  void Evaluate(double k, double penalty, const Vec<N>& x) {
    offset = J * x + still;
    law = f + penalty * (offset - (f - held) / k);
    law[0] = std::max(0.0, law[0]);
    const double limit = mu * law[0], length = law.tail<2>().norm();
    ratio = length <= limit ? 1.0 : limit / length;
    if (!slips()) return;
    direction = law.tail<2>() / length;
    law.tail<2>() *= ratio;
  }

  /// Linearises the law where it was evaluated.  Across its direction, friction that slips turns
  /// with the slip as Newton's step for the projection says.
  void Linearise(double k, double penalty) {
    mean = held + k * offset;
    rate = k * J;
    if (law[0] == 0.0) {
      mean[0] = 0.0;
      rate.row(0).setZero();
    }
    if (!slips()) return;
    const double left = 1.0 - ratio * (1.0 - penalty / k);
    const Vec2 across(-direction[1], direction[0]);
    const Eigen::Matrix<double, 1, N> turn =
        penalty * ratio / left * across.transpose() * J.template bottomRows<2>();
    mean.tail<2>() =
        mu * mean[0] * direction + (1.0 - 1.0 / left) * across.dot(friction()) * across;
    for (int i = 0; i < 2; ++i) {
      rate.row(1 + i) = across[i] * turn + mu * direction[i] * rate.row(0);
    }
  }
};

/// The contacts of a sub-step, and the method that finds their forces.  Lengths in metres, and
/// forces too, divided by k_t of the first tool.  Unknowns are those of SolveRows.
template <int N>
class FrictionalContacts {
 public:
  using Contact = palpate::Contact<N>;

  FrictionalContacts(Party tools, const Vec<N>& t)
      : tools_(tools), t_(t), slack_(Lead(tools).advance.optimum.qp.slack) {
    Vec<N> x = Vec<N>::Zero();
    for (std::size_t i = 0; i < tools_.size(); ++i) {
      Block(x, i) = tools_[i]->ToUnknowns(Vec6::Map(tools_[i]->advance.optimum.qp.x));
    }
    size_ = t_.norm() + (t_ - x).norm();
    Begin();
  }

  /// Begins with the contacts of the last sub-step that are still near, with their forces, and
  /// those of the frictionless optimum.  If there are any of the former, the others start without
  /// force, because the former balanced the hand.
  void Begin() {
    count_ = 0;
    for (std::size_t i = 0; i < tools_.size(); ++i) {
      const FrictionState& state = tools_[i]->friction;
      const double weight = tools_[i]->weight;
      for (std::size_t k = 0; k < static_cast<std::size_t>(state.contacts); ++k) {
        int row;
        if (tools_[i]->buffers().rows.Find({&state.id[k], 1}, &row) == 1) {
          Add({i, row}, weight * state.normal_force[k], weight * state.force[k]);
        }
      }
    }
    const bool warm = count_ > 0;
    for (std::size_t i = 0; i < tools_.size(); ++i) {
      const QpResult& frictionless = tools_[i]->advance.optimum.qp;
      for (int k = 0; k < frictionless.active; ++k) {
        Add({i, frictionless.row[k]}, warm ? 0.0 : tools_[i]->weight * frictionless.multiplier[k]);
      }
    }
  }

  const Contact* begin() const { return contact_; }
  const Contact* end() const { return contact_ + count_; }
  Contact* begin() { return contact_; }
  Contact* end() { return contact_ + count_; }

  /// Adds a contact.  Returns false if the row is there already, or there is no room.
  /// @param lambda, force  where Newton's method starts
  bool Add(const ToolRow& of, double lambda = 0.0, const Vec3& force = Vec3::Zero()) {
    if (std::any_of(begin(), end(), [of](const auto& c) { return c.of == of; })) return false;
    if (count_ == kMost) DropUnloaded();
    if (count_ == kMost) return false;
    const StepContext& tool = *tools_[of.tool];
    const HapticModel& model = tool.model;
    const ContactRows& rows = tool.buffers().rows;
    const int row = of.row;
    const Material& material = model.MaterialOf(rows.id(row), tool.state().solids);
    Contact& contact = contact_[count_++];
    contact.of = of;
    contact.mu_s = material.static_friction;
    contact.mu_d = material.dynamic_friction;
    const bool slid = tool.friction.still < model.parameters().still_cycles;
    contact.mu = slid ? contact.mu_d : contact.mu_s;
    const Vec3 n = rows.normal(row), s0 = n.unitOrthogonal(), s1 = n.cross(s0);
    // Slip is that of the point where it touches when the row holds.  Otherwise corners of a face
    // that comes down on a plane would slip against each other by their gaps times its turn.
    contact.lever = rows.LeverOf(row, model.tool().leaves, tool.tools.R_WG);
    contact.body = tool.MotionOf(rows.id(row));
    const auto moved = [&] {
      return contact.body == nullptr ? Vec3(Vec3::Zero()) : contact.body->BodyAt(contact.lever);
    };
    // The row's gap is that to where the body goes.
    contact.lever -= (rows.gap(row) + n.dot(moved())) * n;
    contact.axes << -n.transpose(), s0.transpose(), s1.transpose();
    if constexpr (N > 6) contact.J.setZero();
    const auto turn_about = [&](const Vec3& lever, const Vec3& by_rotation) {
      Mat3 turns;  // columns
      turns << -by_rotation, lever.cross(s0), lever.cross(s1);
      if (model.is_ball()) turns.setZero();
      return turns;
    };
    contact.still = -contact.axes * moved();
    contact.still[0] = tool.sub_step.rigid.b[row] - slack_;
    const auto block = [&](std::size_t i, const Mat3& axes, const Mat3& turns) {
      const StepContext& of_block = *tools_[i];
      auto J = contact.J.template middleCols<6>(6 * static_cast<int>(i));
      const double rho = of_block.model.rotation_length(), scale = of_block.Scale();
      if (!of_block.metric) {
        J.template leftCols<3>() = axes / scale;
        J.template rightCols<3>() = turns.transpose() / (rho * scale);
        return;
      }
      J.template leftCols<3>() = axes;
      J.template rightCols<3>() = turns.transpose() / rho;
      contact.still += J * of_block.metric->c;
      J = (J * of_block.metric->B / scale).eval();
    };
    block(of.tool, contact.axes, turn_about(contact.lever, rows.lever_cross_normal(row)));
    contact.other = rows.with_others() ? rows.other(row).tool : -1;
    if (contact.other >= 0) {
      const auto j = static_cast<std::size_t>(contact.other);
      contact.other_lever = contact.lever + tool.tools.p_G - tools_[j]->tools.p_G;
      block(j, -contact.axes, -turn_about(contact.other_lever, -rows.other(row).phi));
    }
    contact.f = contact.axes * force;
    contact.f[0] = lambda;
    return true;
  }

  /// Finds the frictional optimum over these contacts alone.  Returns whether it was found.
  bool Solve() {
    do {
      for (Contact& contact : *this) contact.held.setZero();
      stiffness_ = kStiffness;
      if (!Newton() && !Stiffen()) return false;
      settled_ = Settle();
    } while (LetSlip());
    return true;
  }
  bool settled() const { return settled_; }

  /// Solves the QP over all rows for t less the friction, into each tool's `nearest`.  Returns
  /// whether it ended.
  bool SolveShifted() {
    Vec<N> t = t_;
    ToolRow guess[kMost];
    std::size_t guesses = 0;
    for (const Contact& contact : *this) {
      t -= contact.J.template bottomRows<2>().transpose() * contact.friction();
      if (contact.lambda() > 0.0) guess[guesses++] = contact.of;
    }
    SolveRows(tools_, t.data(), {guess, guesses});
    bool solved = true;
    for (StepContext* tool : tools_) {
      tool->report().diagnostics.qp_iterations += tool->nearest.qp.iterations;
      solved &= tool->nearest.qp.status != QpStatus::kIterationLimit;
    }
    return solved;
  }

  /// Adds the rows that hold the tools at its solution; returns whether any was missing.
  bool AddRowsOfShifted() {
    bool added = false;
    for (std::size_t i = 0; i < tools_.size(); ++i) {
      for (const int row : tools_[i]->nearest.qp.ActiveRows()) added |= Add({i, row});
    }
    return added;
  }

  /// Returns whether no row is violated by more than contacts may yield.
  bool Hold() const { return RowsHold(tools_, x_.data(), slack_ + kExact * size_); }

  /// Takes over the QP's x, which violates nothing, if it differs only as this one may be off.
  void Follow() {
    Vec<N> x = x_;
    for (std::size_t i = 0; i < tools_.size(); ++i) {
      Block(x, i) = tools_[i]->ToUnknowns(Vec6::Map(tools_[i]->nearest.qp.x));
    }
    if (Largest(x - x_) <= 10.0 * kSolved * size_) x_ = x;
  }

  /// Takes over the normal forces of the QP, and projects friction onto its disks.  Returns whether
  /// that changed anything, so that the QP must be solved again.
  bool Project() {
    bool changed = false;
    for (Contact& contact : *this) {
      const StepContext& tool = *tools_[contact.of.tool];
      contact.f[0] = tool.weight * MultiplierOf(tool.nearest.qp, contact.of.row);
      const double limit = contact.mu * contact.lambda(), length = contact.friction().norm();
      if (length <= limit + kSolved * size_) continue;
      contact.friction() *= limit / length;
      changed = true;
    }
    DropUnloaded();
    for (std::size_t i = 0; i < tools_.size(); ++i) {
      const QpResult& qp = tools_[i]->nearest.qp;
      for (int k = 0; k < qp.active; ++k) {
        Add({i, qp.row[k]}, tools_[i]->weight * qp.multiplier[k]);
      }
    }
    return changed;
  }

  /// Returns whether a contact of a tool slips.
  bool Slides(std::size_t tool) const {
    return std::any_of(begin(), end(),
                       [&](const auto& c) { return IsOf(c, tool) && Slides(c) && c.mu_s > 0.0; });
  }

  /// Returns what a tool's v must compensate so that a sticking point stays in place when tools
  /// turn about it by finite angles, as the mean over the sticking points.  Otherwise a stylus that
  /// trembles about its tip would creep by the second order.  Of two tools each compensates the
  /// share that leaves their forces in balance.
  Vec3 Creep(std::size_t tool) const {
    Vec3 sum = Vec3::Zero();
    int sticking = 0;
    const StepContext& of = *tools_[tool];
    const Vec3 phi = TurnOf(of);
    if (phi.norm() > of.model.parameters().max_rotation) return sum;
    if (of.metric && of.model.inertia()->body.joint.kind != BodyJoint::Kind::kFree) return sum;
    const Quat turn = RotationExp(phi);
    for (const Contact& contact : *this) {
      if (!IsOf(contact, tool)) continue;
      if (Slides(contact) || contact.lambda() == 0.0 || contact.mu_s == 0.0) continue;
      const bool is_owner = contact.of.tool == tool;
      Vec3 rest = BendOf(turn, phi, is_owner ? contact.lever : contact.other_lever);
      if (contact.body != nullptr) rest -= contact.body->BendAt(contact.lever);
      if (contact.other >= 0) {
        const StepContext& other =
            *tools_[is_owner ? static_cast<std::size_t>(contact.other) : contact.of.tool];
        const Vec3 others = TurnOf(other);
        rest -= BendOf(RotationExp(others), others, is_owner ? contact.other_lever : contact.lever);
        rest *= other.weight / (of.weight + other.weight);
      }
      const Vec3 n = contact.axes.row(0);
      sum += rest - rest.dot(n) * n;
      ++sticking;
    }
    return sticking == 0 ? sum : Vec3(sum / sticking);
  }

  /// Writes x, and the contacts that carry force.
  /// @param solved  whether this is the solution; else x is that of the QP
  void Write(bool solved) const {
    for (std::size_t i = 0; i < tools_.size(); ++i) {
      StepContext& tool = *tools_[i];
      FrictionState& state = tool.friction;
      QpResult& qp = tool.advance.optimum.qp;
      if (solved) {
        Vec6::Map(qp.x) = tool.FromUnknowns(x_.template segment<6>(6 * static_cast<int>(i)));
      } else {
        std::ranges::copy(tool.nearest.qp.x, qp.x);
      }
      qp.active = 0;
      for (const Contact& contact : *this) {
        if (contact.of.tool != i || contact.f.isZero(0.0)) continue;
        if (contact.other >= 0) {
          tools_[static_cast<std::size_t>(contact.other)]->advance.optimum.is_touched = true;
        }
        if (qp.active == kMaxActiveRows) continue;
        const auto k = static_cast<std::size_t>(qp.active++);
        qp.row[k] = contact.of.row;
        // It may be slightly negative by rounding.
        qp.multiplier[k] = std::max(0.0, contact.lambda() / tool.weight);
        state.id[k] = tool.buffers().rows.id(contact.of.row);
        state.normal_force[k] = qp.multiplier[k];
        state.force[k] =
            contact.axes.template bottomRows<2>().transpose() * contact.friction() / tool.weight;
        tool.advance.optimum.friction[k] = -state.force[k];
      }
      state.contacts = qp.active;
    }
  }

  /// Lets the contacts hold their forces where they are offset by nothing, so that what sticks does
  /// not move, and rows yield by their disagreement and not by their load.  In a wedge steeper than
  /// the friction angle the forces then have no bound: the contacts stay as they are, and the
  /// result is false.
  bool Settle() {
    for (Contact& contact : *this) contact.before = std::exchange(contact.held, contact.f);
    if (Newton()) return true;
    for (Contact& contact : *this) contact.held = contact.before;
    Error();
    return false;
  }

 private:
  static constexpr int kMost = kMaxActiveRows * N / 6;

  static auto Block(Vec<N>& x, std::size_t i) {
    return x.template segment<6>(6 * static_cast<int>(i));
  }
  /// Returns a tool's turn at the optimum that Write has given it.
  static Vec3 TurnOf(const StepContext& tool) {
    return Vec3::Map(tool.advance.optimum.qp.x + 3) / tool.model.rotation_length();
  }
  /// Returns how much farther a point moves by a turn than to first order.
  static Vec3 BendOf(const Quat& turn, const Vec3& phi, const Vec3& lever) {
    return turn * lever - lever - phi.cross(lever);
  }
  static bool IsOf(const Contact& contact, std::size_t tool) {
    return contact.of.tool == tool || contact.other == static_cast<int>(tool);
  }
  bool Slides(const Contact& contact) const {
    return contact.slips() && contact.lambda() != 0.0 && contact.slip() > kSlid * size_;
  }

  void DropUnloaded() {
    const auto kept =
        std::remove_if(begin(), end(), [](const auto& c) { return c.lambda() == 0.0; });
    count_ = static_cast<int>(kept - begin());
  }

  /// Computes the x that balances the forces.
  void Balance() {
    x_ = t_;
    for (const Contact& contact : *this) x_.noalias() -= contact.J.transpose() * contact.f;
  }

  /// Evaluates the law at x; returns the greatest error of a force.
  double Error() {
    double most = 0.0;
    for (Contact& contact : *this) {
      contact.Evaluate(stiffness_, penalty_, x_);
      most = std::max(most, Largest(contact.law - contact.f));
    }
    return most;
  }

  /// Returns the step of Newton's method from where the law was evaluated.
  Vec<N> Step() {
    Vec<N> g = t_ - x_;
    Mat<N> H = Mat<N>::Identity();
    for (Contact& contact : *this) {
      contact.Linearise(stiffness_, penalty_);
      g.noalias() -= contact.J.transpose() * contact.mean;
      H.noalias() += contact.J.transpose() * contact.rate;
    }
    return SolveLinear(H, g);
  }

  /// Newton's method with one penalty or another.
  bool Newton() {
    return std::ranges::any_of(kPenalties, [&](double penalty) {
      penalty_ = penalty;
      return NewtonFrom();
    });
  }

  /// Semismooth Newton method in x and the forces, from these.  A step whose error is not less than
  /// the greatest of the last three is halved; x and forces are scaled together, so that they stay
  /// in balance.  If it does not end, everything is as before.
  bool NewtonFrom() {
    for (Contact& contact : *this) contact.start = contact.f;
    Balance();
    double error = Error(), last[3] = {};
    for (int step = 0; step == 0 || error > kSolved * size_; ++step) {
      if (step == kSteps) {
        for (Contact& contact : *this) contact.f = contact.start;
        Balance();
        Error();
        return false;
      }
      ++Lead(tools_).report().diagnostics.friction_iterations;
      last[step % 3] = error;
      const double bound = std::max({last[0], last[1], last[2]});
      Vec<N> d = Step();
      for (Contact& contact : *this) contact.moved = contact.mean + contact.rate * d - contact.f;
      double fraction = 1.0;
      for (int halving = 0; halving <= kHalvings; ++halving) {
        x_ += fraction * d;
        for (Contact& contact : *this) contact.f += fraction * contact.moved;
        error = Error();
        if (error < bound) break;
        fraction = halving == 0 ? -0.5 : 0.5 * fraction;
      }
    }
    return true;
  }

  /// Finds the forces of contacts that begin as soft as the hand's spring, where they are known,
  /// and are stiffened in stages, each of which begins from the forces of the last.  The stiffest
  /// that are found count.
  bool Stiffen() {
    for (Contact& contact : *this) contact.f.setZero();
    double found = 0.0;
    for (stiffness_ = 1.0; stiffness_ <= kStiffness; stiffness_ *= 2.0) {
      if (Newton()) found = stiffness_;
    }
    stiffness_ = found;
    return found >= kSoftest && Newton();
  }

  /// Gives mu_d to the contacts that mu_s does not hold; returns whether that changes anything.
  bool LetSlip() {
    bool any = false;
    for (Contact& contact : *this) {
      if (contact.mu == contact.mu_d || !Slides(contact)) continue;
      contact.mu = contact.mu_d;
      any = true;
    }
    return any;
  }

  Party tools_;
  Vec<N> t_, x_;
  double slack_;      ///< of the frictionless optimum
  double size_;       ///< of the problem: tolerances are relative to it
  double stiffness_;  ///< of contacts, over k_t
  double penalty_ = 0.0;
  bool settled_ = false;
  int count_ = 0;
  Contact contact_[kMost];
};

/// Returns false if the frictionless optima stay.
template <int N>
bool Solve(Party tools) {
  Vec<N> t = Vec<N>::Zero();
  for (std::size_t i = 0; i < tools.size(); ++i) {
    const StepContext& tool = *tools[i];
    const Optimum& optimum = tool.advance.optimum;
    const double rho = tool.model.rotation_length();
    // The push of soft contacts is taken as it is without friction.
    const Vec3 v = tool.sub_step.target.v + optimum.push;
    const Vec3 phi = tool.sub_step.target.phi + optimum.push_torque / (rho * rho);
    t.template segment<6>(6 * static_cast<int>(i)) = tool.ToUnknowns(v, phi);
  }
  FrictionalContacts<N> contacts(tools, t);
  bool solved = false, added = true;
  for (int round = 0; round < kRounds && added; ++round) {
    solved = contacts.Solve();
    bool held = solved && contacts.Hold();
    for (int again = 1; again < kHolds && solved && !held && contacts.settled(); ++again) {
      held = contacts.Settle() && contacts.Hold();
    }
    if (held || !solved) break;
    if (!contacts.SolveShifted()) return false;
    added = contacts.AddRowsOfShifted();
    solved = !added;
    if (solved) contacts.Follow();  // what is violated is what they yield
  }
  if (!solved) {
    for (StepContext* tool : tools) tool->advance.optimum.friction_unsolved = true;
    contacts.Begin();
  }
  for (int projection = 0, most = kMaxActiveRows * N / 6; !solved; ++projection) {
    // One for each contact, and one more.
    if (projection > most + 1 || !contacts.SolveShifted()) return false;
    if (!contacts.Project()) break;
  }
  contacts.Write(solved);
  for (std::size_t i = 0; i < tools.size(); ++i) {
    StepContext& tool = *tools[i];
    Optimum& optimum = tool.advance.optimum;
    if (contacts.Slides(i)) tool.friction.still = 0;
    optimum.friction_yielded = solved && !contacts.settled();
    Vec3::Map(optimum.qp.x) -= contacts.Creep(i);
  }
  return true;
}

}  // namespace

void AddCoulombFriction(Party tools) noexcept {
  for (StepContext* tool : tools) {
    FrictionState& state = tool->friction;
    if (tool->report().diagnostics.substeps == 0 &&
        state.still < tool->model.parameters().still_cycles) {
      ++state.still;
    }
    tool->advance.optimum.has_friction = true;
  }
  const bool solved = Lead(tools).together == nullptr ? Solve<6>(tools)
                      : tools.size() <= 2             ? Solve<12>(tools)
                      : tools.size() <= 4             ? Solve<24>(tools)
                                                      : Solve<48>(tools);
  for (StepContext* tool : tools) {
    Optimum& optimum = tool->advance.optimum;
    if (!solved) {
      for (Vec3& force : optimum.friction) force.setZero();
      tool->friction.contacts = 0;
    }
    optimum.Take(tool->model.rotation_length());
  }
}

}  // namespace palpate
