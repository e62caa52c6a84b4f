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
using Mat6 = Eigen::Matrix<double, 6, 6>;
using Mat36 = Eigen::Matrix<double, 3, 6, Eigen::RowMajor>;
double Largest(const auto& v) {
  return v.template lpNorm<Eigen::Infinity>();
}

double MultiplierOf(const QpResult& qp, int row) {
  const int* found = std::find(qp.row, qp.row + qp.active, row);
  return found == qp.row + qp.active ? 0.0 : qp.multiplier[found - qp.row];
}

/// Solves H x = g by elimination with row exchanges; Eigen's takes twice as long at this size.
Vec6 SolveLinear(const Mat6& H, const Vec6& g) {
  Eigen::Matrix<double, 6, 8, Eigen::RowMajor> A;  // an even width, for vectors
  A << H, g, g;
  for (int k = 0; k < 6; ++k) {
    int pivot;
    A.col(k).tail(6 - k).cwiseAbs().maxCoeff(&pivot);
    A.row(k).swap(A.row(k + pivot));
    for (int i = k + 1; i < 6; ++i) A.row(i) -= A(i, k) / A(k, k) * A.row(k);
  }
  const auto upper = A.leftCols<6>().triangularView<Eigen::Upper>();
  return upper.solve(A.col(6));
}

/// A contact that yields: it pushes back by its stiffness times its offset, within Coulomb's law.
/// Its axes are -n and two tangents.
struct Contact {
  int row;
  Mat3 axes;  ///< row by row, in W
  Vec3 lever;
  const FrameMotion* body;  ///< how what it touches moves; null if it stands
  Mat36 J;                  ///< its motion along the axes, over x
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
  Mat36 rate;
  Vec3 start, before;  ///< f and `held` to go back to

  double lambda() const { return f[0]; }
  auto friction() { return f.tail<2>(); }
  auto friction() const { return f.tail<2>(); }
  bool slips() const { return ratio < 1.0; }
  double slip() const { return offset.tail<2>().norm(); }

  /// Evaluates the law at x and f, with w = r (offset - (f - held) / k) for any r > 0:
  ///   lambda = max(0, lambda + w_1),
  ///   friction = friction + w_2,3, projected onto the disk of radius mu lambda.
  void Evaluate(double k, double penalty, const Vec6& x) {
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
    const Eigen::Matrix<double, 1, 6> turn =
        penalty * ratio / left * across.transpose() * J.bottomRows<2>();
    mean.tail<2>() =
        mu * mean[0] * direction + (1.0 - 1.0 / left) * across.dot(friction()) * across;
    for (int i = 0; i < 2; ++i) {
      rate.row(1 + i) = across[i] * turn + mu * direction[i] * rate.row(0);
    }
  }
};

/// The contacts of a sub-step, and the method that finds their forces.  Lengths in metres, and
/// forces too, divided by k_t.
class FrictionalContacts {
 public:
  FrictionalContacts(const StepContext& context, const Optimum& frictionless, const Vec6& t)
      : context_(context), frictionless_(frictionless.qp), t_(t) {
    size_ = t_.norm() + (t_ - Vec6::Map(frictionless_.x)).norm();
    Begin();
  }

  /// Begins with the contacts of the last sub-step that are still near, with their forces, and
  /// those of the frictionless optimum.  If there are any of the former, the others start without
  /// force, because the former balanced the hand.
  void Begin() {
    const FrictionState& state = context_.friction;
    count_ = 0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(state.contacts); ++i) {
      int row;
      if (context_.buffers().rows.Find({&state.id[i], 1}, &row) == 1) {
        Add(row, state.normal_force[i], state.force[i]);
      }
    }
    const bool warm = count_ > 0;
    for (int i = 0; i < frictionless_.active; ++i) {
      Add(frictionless_.row[i], warm ? 0.0 : frictionless_.multiplier[i]);
    }
  }

  const Contact* begin() const { return contact_; }
  const Contact* end() const { return contact_ + count_; }
  Contact* begin() { return contact_; }
  Contact* end() { return contact_ + count_; }

  /// Adds a contact.  Returns false if the row is there already, or there is no room.
  /// @param lambda, force  where Newton's method starts
  bool Add(int row, double lambda = 0.0, const Vec3& force = Vec3::Zero()) {
    if (std::any_of(begin(), end(), [row](const auto& c) { return c.row == row; })) return false;
    if (count_ == kMaxActiveRows) DropUnloaded();
    if (count_ == kMaxActiveRows) return false;
    const HapticModel& model = context_.model;
    const ContactRows& rows = context_.buffers().rows;
    const Material& material = model.MaterialOf(rows.id(row), context_.state().solids);
    Contact& contact = contact_[count_++];
    contact.row = row;
    contact.mu_s = material.static_friction;
    contact.mu_d = material.dynamic_friction;
    const bool slid = context_.friction.still < model.parameters().still_cycles;
    contact.mu = slid ? contact.mu_d : contact.mu_s;
    const Vec3 n = rows.normal(row), s0 = n.unitOrthogonal(), s1 = n.cross(s0);
    // Slip is that of the point where it touches when the row holds.  Otherwise corners of a face
    // that comes down on a plane would slip against each other by their gaps times its turn.
    contact.lever = rows.LeverOf(row, model.tool().leaves, context_.tools.R_WG);
    contact.body = context_.MotionOf(rows.id(row));
    const auto moved = [&] {
      return contact.body == nullptr ? Vec3(Vec3::Zero()) : contact.body->BodyAt(contact.lever);
    };
    // The row's gap is that to where the body goes.
    contact.lever -= (rows.gap(row) + n.dot(moved())) * n;
    contact.axes << -n.transpose(), s0.transpose(), s1.transpose();
    contact.J.leftCols<3>() = contact.axes;
    Mat3 turns;  // columns
    turns << -rows.lever_cross_normal(row), contact.lever.cross(s0), contact.lever.cross(s1);
    if (model.is_ball()) turns.setZero();
    contact.J.rightCols<3>() = turns.transpose() / model.rotation_length();
    contact.still = -contact.axes * moved();
    contact.still[0] = context_.sub_step.rigid.b[row] - frictionless_.slack;
    contact.f = contact.axes * force;
    contact.f[0] = lambda;
    return true;
  }

  /// Finds the frictional optimum over these contacts alone.  Returns whether it was found.
  bool Solve(StepReport& report) {
    do {
      for (Contact& contact : *this) contact.held.setZero();
      stiffness_ = kStiffness;
      if (!Newton(report) && !Stiffen(report)) return false;
      settled_ = Settle(report);
    } while (LetSlip());
    return true;
  }
  bool settled() const { return settled_; }

  /// Returns t less the friction: the target of the QP over all rows.
  Vec6 ShiftedTarget() const {
    Vec6 t = t_;
    for (const Contact& contact : *this) {
      t -= contact.J.bottomRows<2>().transpose() * contact.friction();
    }
    return t;
  }

  const Vec6& x() const { return x_; }
  /// Takes over the QP's x, which violates nothing, if it differs only as this one may be off.
  void Follow(const double* x) {
    if (Largest(Vec6::Map(x) - x_) <= 10.0 * kSolved * size_) x_ = Vec6::Map(x);
  }
  /// By how much x may violate a row.
  double tolerance() const { return frictionless_.slack + kExact * size_; }

  /// Takes over the normal forces of the QP, and projects friction onto its disks.  Returns whether
  /// that changed anything, so that the QP must be solved again.
  bool Project(const QpResult& qp) {
    bool changed = false;
    for (Contact& contact : *this) {
      contact.f[0] = MultiplierOf(qp, contact.row);
      const double limit = contact.mu * contact.lambda(), length = contact.friction().norm();
      if (length <= limit + kSolved * size_) continue;
      contact.friction() *= limit / length;
      changed = true;
    }
    DropUnloaded();
    for (int j = 0; j < qp.active; ++j) Add(qp.row[j], qp.multiplier[j]);
    return changed;
  }

  bool slides() const {
    return std::any_of(begin(), end(), [this](const auto& c) { return Slides(c) && c.mu_s > 0.0; });
  }

  /// Returns what v must compensate so that a sticking point stays in place when the tool turns
  /// about it by a finite angle, as the mean over the sticking points.  Otherwise a stylus that
  /// trembles about its tip would creep by the second order.
  Vec3 Creep(const Vec3& phi) const {
    Vec3 sum = Vec3::Zero();
    int sticking = 0;
    const Quat turn = RotationExp(phi);
    for (const Contact& contact : *this) {
      if (Slides(contact) || contact.lambda() == 0.0 || contact.mu_s == 0.0) continue;
      Vec3 rest = turn * contact.lever - contact.lever - phi.cross(contact.lever);
      if (contact.body != nullptr) rest -= contact.body->BendAt(contact.lever);
      const Vec3 n = contact.axes.row(0);
      sum += rest - rest.dot(n) * n;
      ++sticking;
    }
    return sticking == 0 ? sum : Vec3(sum / sticking);
  }

  /// Writes the contacts that carry force.
  void Write(FrictionState& state, QpResult& qp, FrictionForces& forces) const {
    qp.active = 0;
    for (const Contact& contact : *this) {
      if (contact.f.isZero(0.0)) continue;
      const auto k = static_cast<std::size_t>(qp.active++);
      qp.row[k] = contact.row;
      qp.multiplier[k] = std::max(0.0, contact.lambda());  // may be slightly negative by rounding
      state.id[k] = context_.buffers().rows.id(contact.row);
      state.normal_force[k] = qp.multiplier[k];
      state.force[k] = contact.axes.bottomRows<2>().transpose() * contact.friction();
      forces[k] = -state.force[k];
    }
    state.contacts = qp.active;
  }

  /// Lets the contacts hold their forces where they are offset by nothing, so that what sticks does
  /// not move, and rows yield by their disagreement and not by their load.  In a wedge steeper than
  /// the friction angle the forces then have no bound: the contacts stay as they are, and the
  /// result is false.
  bool Settle(StepReport& report) {
    for (Contact& contact : *this) contact.before = std::exchange(contact.held, contact.f);
    if (Newton(report)) return true;
    for (Contact& contact : *this) contact.held = contact.before;
    Error();
    return false;
  }

 private:
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
  Vec6 Step() {
    Vec6 g = t_ - x_;
    Mat6 H = Mat6::Identity();
    for (Contact& contact : *this) {
      contact.Linearise(stiffness_, penalty_);
      g.noalias() -= contact.J.transpose() * contact.mean;
      H.noalias() += contact.J.transpose() * contact.rate;
    }
    return SolveLinear(H, g);
  }

  /// Newton's method with one penalty or another.
  bool Newton(StepReport& report) {
    return std::ranges::any_of(kPenalties, [&](double penalty) {
      penalty_ = penalty;
      return NewtonFrom(report);
    });
  }

  /// Semismooth Newton method in x and the forces, from these.  A step whose error is not less than
  /// the greatest of the last three is halved; x and forces are scaled together, so that they stay
  /// in balance.  If it does not end, everything is as before.
  bool NewtonFrom(StepReport& report) {
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
      ++report.diagnostics.friction_iterations;
      last[step % 3] = error;
      const double bound = std::max({last[0], last[1], last[2]});
      Vec6 d = Step();
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
  bool Stiffen(StepReport& report) {
    for (Contact& contact : *this) contact.f.setZero();
    double found = 0.0;
    for (stiffness_ = 1.0; stiffness_ <= kStiffness; stiffness_ *= 2.0) {
      if (Newton(report)) found = stiffness_;
    }
    stiffness_ = found;
    return found >= kSoftest && Newton(report);
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

  const StepContext& context_;
  const QpResult& frictionless_;
  Vec6 t_, x_;
  double size_;       ///< of the problem: tolerances are relative to it
  double stiffness_;  ///< of contacts, over k_t
  double penalty_ = 0.0;
  bool settled_ = false;
  int count_ = 0;
  Contact contact_[kMaxActiveRows];
};

/// Returns false if the frictionless optimum stays.
/// @param t  the target
bool Solve(StepContext& context, Optimum& optimum, const Vec6& t) {
  StepReport& report = context.report();
  FrictionalContacts contacts(context, optimum, t);
  QpResult qp;
  const auto solve_shifted = [&] {
    int guess[kMaxActiveRows], guesses = 0;
    for (const Contact& contact : contacts) {
      if (contact.lambda() > 0.0) guess[guesses++] = contact.row;
    }
    qp = context.kernels.solve(contacts.ShiftedTarget().data(), context.sub_step.rigid, guess,
                               guesses);
    report.diagnostics.qp_iterations += qp.iterations;
    return qp.status != QpStatus::kIterationLimit;
  };
  const auto holds = [&] {
    return context.kernels.rows_hold(context.sub_step.rigid, contacts.x().data(),
                                     contacts.tolerance());
  };
  bool solved = false, added = true;
  for (int round = 0; round < kRounds && added; ++round) {
    solved = contacts.Solve(report);
    bool held = solved && holds();
    for (int again = 1; again < kHolds && solved && !held && contacts.settled(); ++again) {
      held = contacts.Settle(report) && holds();
    }
    if (held || !solved) break;
    if (!solve_shifted()) return false;
    added = false;
    for (int i = 0; i < qp.active; ++i) added |= contacts.Add(qp.row[i]);
    solved = !added;
    if (solved) contacts.Follow(qp.x);  // what is violated is what they yield
  }
  if (!solved) {
    optimum.friction_unsolved = true;
    contacts.Begin();
  }
  for (int projection = 0; !solved; ++projection) {
    // One for each contact, and one more.
    if (projection > kMaxActiveRows + 1 || !solve_shifted()) return false;
    if (!contacts.Project(qp)) break;
  }
  if (contacts.slides()) context.friction.still = 0;
  optimum.friction_yielded = solved && !contacts.settled();
  Vec6::Map(optimum.qp.x) = solved ? contacts.x() : Vec6::Map(qp.x);
  contacts.Write(context.friction, optimum.qp, optimum.friction);
  const Vec3 phi = Vec3::Map(optimum.qp.x + 3) / context.model.rotation_length();
  if (phi.norm() <= context.model.parameters().max_rotation) {
    Vec3::Map(optimum.qp.x) -= contacts.Creep(phi);
  }
  return true;
}

}  // namespace

void AddCoulombFriction(StepContext& context, Optimum& optimum) noexcept {
  FrictionState& state = context.friction;
  if (context.report().diagnostics.substeps == 0 &&
      state.still < context.model.parameters().still_cycles) {
    ++state.still;
  }
  const double rho = context.model.rotation_length();
  // The push of soft contacts is taken as it is without friction.
  const Vec3 v = context.sub_step.target.v + optimum.push;
  const Vec3 phi = context.sub_step.target.phi + optimum.push_torque / (rho * rho);
  Vec6 t;
  t << v, rho * phi;
  optimum.has_friction = true;
  if (!Solve(context, optimum, t)) {
    for (Vec3& force : optimum.friction) force.setZero();
    state.contacts = 0;
  }
  optimum.Take(rho);
}

}  // namespace palpate
