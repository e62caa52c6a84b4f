#include <algorithm>
#include <cmath>

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
  Vec6 x;
  for (int k = 6 - 1; k >= 0; --k) {
    for (int j = k + 1; j < 6; ++j) A(k, 6) -= A(k, j) * x[j];
    x[k] = A(k, 6) / A(k, k);
  }
  return x;
}

/// Which form of Coulomb's law is solved for (friction.md): the true one, in x and the forces; that
/// of contacts with a stiffness, in x alone; or this one with fixed limits of friction, where it is
/// the gradient of a convex function.
struct Law {
  double r;  ///< penalty with which it decides whether a contact presses and slips
  double k;  ///< stiffness, over k_t, of what presses or sticks
  enum class Form { kTrue, kStiff, kFixed } form;
};
constexpr Law kTrueLaw{kTrial, kPenalty, Law::Form::kTrue};
constexpr Law kStiffLaw{kStiffness, kStiffness, Law::Form::kStiff};
constexpr Law kFixedLaw{kStiffness, kStiffness, Law::Form::kFixed};

/// The law of a contact, evaluated at an x and linearised there.
struct LawAtX {
  Vec3 offset;         ///< (b - a . x, slip)
  Vec3 law;            ///< f
  double limit;        ///< of friction
  double ratio = 1.0;  ///< of the limit to what friction would be without it; 1 if it sticks
  Vec2 direction;      ///< of the slip
  Vec3 mean;           ///< f = mean + rate dx
  Mat36 rate;
};

/// A contact: its axes are -n and two tangents.
struct Contact : LawAtX {
  int row;
  Mat3 axes;  ///< row by row, in W
  Vec3 lever;
  Mat36 J;                ///< its motion along the axes, over x
  double b;               ///< of its row a . x >= b
  double mu, mu_s, mu_d;  ///< mu is one of the two
  Vec3 f;                 ///< (lambda, friction), against the motion: the tool feels -J^T f
  Vec3 old, moved;        ///< f before a step, and what the step adds

  double lambda() const { return f[0]; }
  auto friction() { return f.tail<2>(); }
  auto friction() const { return f.tail<2>(); }
  bool slips() const { return ratio < 1.0; }
  Vec2 SlipAt(const Vec6& x) const { return J.bottomRows<2>() * x; }
  /// Returns what friction takes off x.
  Vec6 Rub() const { return J.bottomRows<2>().transpose() * friction(); }

  /// Evaluates the law at x:
  ///   lambda = max(0, lambda + r (b - a . x)),
  ///   friction = friction + r slip, projected onto the disk of radius mu lambda.
  void Evaluate(const Law& by, const Vec6& x) {
    offset = J * x + Vec3(b, 0.0, 0.0);
    const Vec3 trial = f + by.r * offset;
    const Vec2 u = trial.tail<2>();
    const double length = u.norm();
    law = {std::max(0.0, trial[0]), u[0], u[1]};
    if (by.form != Law::Form::kFixed) limit = mu * law[0];
    ratio = 1.0;
    if (length <= limit) return;
    const double inverse = 1.0 / length;
    ratio = limit * inverse;
    direction = inverse * u;
    law.tail<2>() = limit * direction;
  }

  /// Linearises the law where it was evaluated.  Across its direction, friction that slips turns
  /// with the slip as Newton's step for the projection says.
  void Linearise(const Law& by) {
    mean = f + by.k * offset;
    rate = by.k * J;
    if (law[0] == 0.0) {
      mean[0] = 0.0;
      rate.row(0).setZero();
    }
    if (!slips()) return;
    const bool is_fixed = by.form == Law::Form::kFixed;
    const double left =
        by.form == Law::Form::kTrue ? std::max(1.0 - ratio, ratio * by.r / by.k) : 1.0;
    const Vec2 across(-direction[1], direction[0]);
    const Eigen::Matrix<double, 1, 6> turn =
        ratio * by.r / left * across.transpose() * J.bottomRows<2>();
    mean.tail<2>() = (is_fixed ? limit : mu * mean[0]) * direction +
                     (1.0 - 1.0 / left) * across.dot(friction()) * across;
    for (int i = 0; i < 2; ++i) {
      rate.row(1 + i) = across[i] * turn;
      if (!is_fixed) rate.row(1 + i) += mu * direction[i] * rate.row(0);
    }
  }
};

/// The contacts of a sub-step, and two methods that find their forces.  Lengths in metres, and
/// forces too, divided by k_t.
class FrictionalContacts {
 public:
  FrictionalContacts(const StepContext& context, const Optimum& frictionless, const Vec6& t)
      : context_(context), frictionless_(frictionless.qp), t_(t) {
    size_ = t_.norm() + (t_ - Vec6::Map(frictionless_.x)).norm();
    Collect();
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
    const Material& material = model.MaterialOf(rows.id(row), context_.state().felt);
    Contact& contact = contact_[count_++];
    contact.row = row;
    contact.mu_s = material.static_friction;
    contact.mu_d = material.dynamic_friction;
    const bool slid = context_.state().friction.still < model.parameters().still_cycles;
    contact.mu = slid ? contact.mu_d : contact.mu_s;
    const Vec3 n = rows.normal(row), s0 = n.unitOrthogonal(), s1 = n.cross(s0);
    // Slip is that of the point where it touches when the row holds.  Otherwise corners of a face
    // that comes down on a plane would slip against each other by their gaps times its turn.
    contact.lever = rows.LeverOf(row, model.tool().leaves, context_.tools.R_WG) - rows.gap(row) * n;
    contact.axes << -n.transpose(), s0.transpose(), s1.transpose();
    contact.J.leftCols<3>() = contact.axes;
    Mat3 turns;  // columns
    turns << -rows.lever_cross_normal(row), contact.lever.cross(s0), contact.lever.cross(s1);
    if (model.is_ball()) turns.setZero();
    contact.J.rightCols<3>() = turns.transpose() / model.rotation_length();
    contact.b = context_.sub_step.rigid.b[row] - frictionless_.slack;
    contact.f = contact.axes * force;
    contact.f[0] = lambda;
    contact.ratio = 1.0;
    return true;
  }

  /// Finds the frictional optimum over these contacts alone.  Returns whether it was found.
  bool Solve(StepReport& report) {
    is_stiff_ = false;
    do {
      if (!Newton(kNewtonSteps, report) && !StiffContacts(report)) return false;
    } while (LetSlip());
    return true;
  }

  /// Returns t less the friction: the target of the QP over all rows.
  Vec6 ShiftedTarget() const {
    Vec6 t = t_;
    for (const Contact& contact : *this) t -= contact.Rub();
    return t;
  }

  /// Returns whether the QP has found the same x, except for what the contacts yield.
  bool Agrees(const double* x) const {
    return Largest(Vec6::Map(x) - x_) <= (is_stiff_ ? kYielded : kAgreed) * size_;
  }
  /// The x of contacts with a stiffness; null if the QP's is exact.
  const Vec6* StiffX() const { return is_stiff_ ? &x_ : nullptr; }

  /// Sets friction back to what it was in the last sub-step.
  void TakeLastFriction() {
    const FrictionState& state = context_.state().friction;
    for (Contact& contact : *this) {
      const ContactId& id = context_.buffers().rows.id(contact.row);
      const auto* end = state.id.begin() + state.contacts;
      const auto* last = std::find(state.id.begin(), end, id);
      contact.f.setZero();
      if (last == end) continue;
      contact.f = contact.axes * state.force[static_cast<std::size_t>(last - state.id.begin())];
      contact.f[0] = 0.0;
    }
  }

  /// Takes over the normal forces of the QP, and projects friction onto its disks.  Returns whether
  /// that changed anything, so that the QP must be solved again.
  bool Project(const QpResult& qp) {
    bool changed = false;
    for (Contact& contact : *this) {
      contact.f[0] = MultiplierOf(qp, contact.row);
      const double limit = contact.mu * contact.lambda(), length = contact.friction().norm();
      if (length <= limit + kBalanced * size_) continue;
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
      const Vec3 rest = turn * contact.lever - contact.lever - phi.cross(contact.lever);
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

 private:
  /// Adds the contacts of the last sub-step that are still near, with their forces, and those of
  /// the frictionless optimum.  If there are any of the former, the others start without force,
  /// because the former balanced the hand.
  void Collect() {
    const FrictionState& state = context_.state().friction;
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

  bool Slides(const Contact& contact) const {
    return contact.slips() && contact.lambda() != 0.0 && contact.SlipAt(x_).norm() > kSlid * size_;
  }

  void DropUnloaded() {
    const auto kept =
        std::remove_if(begin(), end(), [](const auto& c) { return c.lambda() == 0.0; });
    count_ = static_cast<int>(kept - begin());
  }

  /// Returns the step of Newton's method from where the law was evaluated.
  Vec6 Step(const Law& by) {
    Vec6 g = t_ - x_;
    Mat6 H = Mat6::Identity();
    for (Contact& contact : *this) {
      contact.Linearise(by);
      g.noalias() -= contact.J.transpose() * contact.mean;
      H.noalias() += contact.J.transpose() * contact.rate;
    }
    return SolveLinear(H, g);
  }

  /// Computes the x that balances the forces.
  void Balance() {
    x_ = t_;
    for (const Contact& contact : *this) x_.noalias() -= contact.J.transpose() * contact.f;
  }

  /// Evaluates the true law at x; returns the greatest error of a force.
  double Error() {
    double most = 0.0;
    for (Contact& contact : *this) {
      contact.Evaluate(kTrueLaw, x_);
      most = std::max(most, Largest(contact.law - contact.f));
    }
    return most;
  }

  /// Semismooth Newton method for the true law, in x and the forces.  A step whose error is greater
  /// than in each of the last three is halved; x and forces are scaled together, so that they stay
  /// in balance.  If two contacts hold the tool between them, rows and sticking contradict each
  /// other by the rounding of the gaps; then kNear is the best possible.
  bool Newton(int steps, StepReport& report) {
    Balance();
    double error = Error(), before[3] = {};
    for (int step = 0; error > kSolved * size_; ++step) {
      if (step == steps) return error <= kNear * size_;
      ++report.diagnostics.friction_iterations;
      const double last = before[step % 3] = error;
      const double bound = std::max({before[0], before[1], before[2]});
      const Vec6 from = x_, d = Step(kTrueLaw);
      for (Contact& contact : *this) {
        contact.old = contact.f;
        contact.moved = contact.mean + contact.rate * d - contact.f;
      }
      const auto go = [&](double part) {
        x_ = from + part * d;
        for (Contact& contact : *this) contact.f = contact.old + part * contact.moved;
        return Error();
      };
      error = go(1.0);
      if (last <= kNear * size_ && error >= last) {
        go(0.0);
        return true;
      }
      double part = 1.0;
      for (int halving = 0; error >= bound && halving < kHalvings; ++halving) {
        error = go(part *= 0.5);
      }
    }
    return true;
  }

  /// Evaluates a law with a stiffness at x.  Returns x - t + sum J^T f, zero where the forces are
  /// in balance.
  Vec6 Imbalance(const Law& by) {
    Vec6 g = x_ - t_;
    for (Contact& contact : *this) {
      contact.Evaluate(by, x_);
      g.noalias() += contact.J.transpose() * contact.law;
    }
    return g;
  }

  /// Newton's method in x alone.  Each step reduces the imbalance; if none does, x stays where it
  /// was, and the result is false.
  bool Rebalance(StepReport& report) {
    const Vec6 start = x_;
    Vec6 g = Imbalance(kStiffLaw);
    for (int step = 0; step < kRebalanceSteps && Largest(g) > kBalanced * size_; ++step) {
      ++report.diagnostics.friction_iterations;
      const Vec6 from = x_, d = Step(kStiffLaw);
      const double before = g.norm();
      double part = 1.0;
      for (int halving = 0; halving <= kStiffHalvings; ++halving, part *= 0.5) {
        x_ = from + part * d;
        g = Imbalance(kStiffLaw);
        if (g.norm() <= (1.0 - kLeastGain * part) * before) break;
      }
      if (!(g.norm() < before)) break;
    }
    if (Largest(g) <= kBalanced * size_) return true;
    x_ = start;
    return false;
  }

  /// Minimises with fixed limits by Newton's method.  A step that overshoots is shortened between
  /// where its slope falls and where it rises, which always leads down in a convex function.
  void Minimise(StepReport& report) {
    Vec6 g = Imbalance(kFixedLaw);
    for (int step = 0; step < kMinimiserSteps && Largest(g) > kBalanced * size_; ++step) {
      ++report.diagnostics.friction_iterations;
      const Vec6 from = x_, d = Step(kFixedLaw);
      const double slope = g.dot(d), enough = -kSlopeLeft * slope;
      double low = 0.0, high = 1.0, falls = slope, rises = 0.0, part = 1.0;
      for (int shorter = 0; shorter <= kShorter; ++shorter) {
        x_ = from + part * d;
        g = Imbalance(kFixedLaw);
        const double here = g.dot(d);
        if (here <= enough && (part == 1.0 || here >= -enough)) break;
        (here < 0.0 ? low : high) = part;
        (here < 0.0 ? falls : rises) = here;
        part = low + (high - low) * std::clamp(falls / (falls - rises), 0.1, 0.9);
      }
    }
  }

  /// Finds x and the forces for contacts with a stiffness, which makes the loads of a face on a
  /// plane determined: by Newton's method or, if that fails, as a minimum with fixed limits, which
  /// then follow the normal forces (friction.md).  The law starts again from the friction found,
  /// so that what sticks does not move; from the normal forces once only, so that they stay
  /// determined.  If Newton's method for the true law ends from there, its result is taken.
  bool StiffContacts(StepReport& report) {
    is_stiff_ = true;
    for (Contact& contact : *this) {
      contact.f = {MultiplierOf(frictionless_, contact.row), 0.0, 0.0};
      contact.limit = contact.mu * contact.lambda();
    }
    Balance();
    for (Contact& contact : *this) contact.f[0] = 0.0;
    for (int turn = 0; turn < kTurns; ++turn) {
      if (!Rebalance(report)) Minimise(report);
      double slip = 0.0, change = 0.0;
      for (Contact& contact : *this) {
        const double limit = contact.mu * contact.law[0];
        slip = std::max(slip, Largest(contact.law.tail<2>() - contact.friction()) / kStiffness);
        change = std::max(change, std::fabs(limit - contact.limit));
        contact.limit = limit;
        contact.friction() = contact.law.tail<2>();
        if (turn == 0) contact.f[0] = contact.law[0];
      }
      if (turn > 0 && slip <= kSolved * size_ && change <= kBalanced * size_) {
        for (Contact& contact : *this) contact.f = contact.law;
        const FrictionalContacts found = *this;
        is_stiff_ = !Newton(kSecondSteps, report);
        if (is_stiff_) {
          std::copy(found.begin(), found.end(), begin());
          x_ = found.x_;
          ++report.diagnostics.friction_yielded;
        }
        return true;
      }
    }
    return false;
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
  double size_;            ///< of the problem: tolerances are relative to it
  bool is_stiff_ = false;  ///< whether the last forces are those of contacts with a stiffness
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
  bool solved = false, added = true;
  for (int round = 0; round < kRounds && added && !solved; ++round) {
    const bool found = contacts.Solve(report);
    if (!solve_shifted()) return false;
    added = false;
    for (int i = 0; i < qp.active; ++i) added |= contacts.Add(qp.row[i]);
    // If the QP's solution rests on these contacts alone, both have found the same x.
    solved = found && (!added || contacts.Agrees(qp.x));
  }
  if (!solved) {
    ++report.diagnostics.friction_unsolved;
    contacts.TakeLastFriction();
    if (!solve_shifted()) return false;
  }
  for (int projection = 0; !solved && contacts.Project(qp); ++projection) {
    if (projection == kProjections || !solve_shifted()) return false;
  }
  if (contacts.slides()) context.state().friction.still = 0;
  Vec6::Map(optimum.qp.x) = solved && contacts.StiffX() ? *contacts.StiffX() : Vec6::Map(qp.x);
  contacts.Write(context.state().friction, optimum.qp, optimum.friction);
  const Vec3 phi = Vec3::Map(qp.x + 3) / context.model.rotation_length();
  if (phi.norm() <= context.model.parameters().max_rotation) {
    Vec3::Map(optimum.qp.x) -= contacts.Creep(phi);
  }
  return true;
}

}  // namespace

void AddCoulombFriction(StepContext& context, Optimum& optimum) noexcept {
  FrictionState& state = context.state().friction;
  if (context.report().diagnostics.substeps == 0 &&
      state.still < context.model.parameters().still_cycles) {
    ++state.still;
  }
  const double rho = context.model.rotation_length();
  // The push of soft contacts is taken as it is without friction.
  const Vec3 v = context.sub_step.target.v + optimum.push;
  const Vec3 phi = context.sub_step.target.phi + optimum.push_turn / (rho * rho);
  Vec6 t;
  t << v, rho * phi;
  optimum.rubs = true;
  if (!Solve(context, optimum, t)) {
    for (Vec3& force : optimum.friction) force.setZero();
    state.contacts = 0;
  }
  optimum.Take(rho);
}

}  // namespace palpate
