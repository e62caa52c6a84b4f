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
double Largest(const auto& v) {
  return v.template lpNorm<Eigen::Infinity>();
}

double MultiplierOf(const QpResult& qp, int row) {
  const int* found = std::find(qp.row, qp.row + qp.active, row);
  return found == qp.row + qp.active ? 0.0 : qp.multiplier[found - qp.row];
}

/// The linear system H x = g of one step.  H starts as the identity; forces a (base + k b . x) are
/// added one by one.
template <int N>
class LinearSystem {
 public:
  explicit LinearSystem(const Vec<N>& g) : g_(g) { H_.setIdentity(); }
  void Add(const Vec<N>& a, double base, double k, const Vec<N>& b) {
    g_ -= base * a;
    for (int r = 0; r < N; ++r) H_.row(r) += (k * a[r]) * b.transpose();
  }
  /// Solves by elimination with row exchanges.
  Vec<N> Solve() {
    for (int k = 0; k < N; ++k) {
      int pivot = k;
      for (int i = k + 1; i < N; ++i) {
        if (std::fabs(H_(i, k)) > std::fabs(H_(pivot, k))) pivot = i;
      }
      if (pivot != k) {
        H_.row(pivot).swap(H_.row(k));
        std::swap(g_[pivot], g_[k]);
      }
      const double inverse = 1.0 / H_(k, k);
      for (int i = k + 1; i < N; ++i) {
        const double part = H_(i, k) * inverse;
        for (int j = k + 1; j < N; ++j) H_(i, j) -= part * H_(k, j);
        g_[i] -= part * g_[k];
      }
    }
    for (int k = N - 1; k >= 0; --k) {
      for (int j = k + 1; j < N; ++j) g_[k] -= H_(k, j) * g_[j];
      g_[k] /= H_(k, k);
    }
    return g_;
  }

 private:
  Eigen::Matrix<double, N, N, Eigen::RowMajor> H_;
  Vec<N> g_;
};

/// The contacts of a sub-step, and two methods that find their forces.  Lengths in metres, and
/// forces too, divided by k_t.
template <int N>
class FrictionalContacts {
 public:
  /// @param t  the target, N values
  FrictionalContacts(const StepContext& context, const Optimum& frictionless, const double* t)
      : context_(context), slack_(frictionless.qp.slack), t_(Vec<N>::Map(t)) {
    const Vec<N> moved = t_ - Vec<N>::Map(frictionless.qp.x);
    size_ = std::sqrt(Dot(t_, t_)) + std::sqrt(Dot(moved, moved));
  }

  int count() const { return count_; }

  /// Adds a contact.  Returns false if the row is there already, or there is no room.
  /// @param frictionless, lambda, force  from its optimum: where Newton's method starts
  bool Add(int row, double frictionless, double lambda, const Vec3& force) {
    for (int i = 0; i < count_; ++i) {
      if (contact_[i].row == row) return false;
    }
    if (count_ == kMaxActiveRows) Drop([](const Contact& c) { return c.lambda() == 0.0; }, 1);
    if (count_ == kMaxActiveRows) return false;
    const HapticModel& model = context_.model;
    const ContactRows& rows = context_.buffers.rows;
    Contact& contact = contact_[count_++];
    contact.row = row;
    contact.normal = rows.normal(row);
    const Material& material = model.MaterialOf(rows.id(row), context_.state.felt);
    contact.lever = rows.LeverOf(row, model.tool().leaves, context_.tools.R_WG);
    contact.mu_s = material.static_friction;
    contact.mu_d = material.dynamic_friction;
    contact.sliding = context_.state.friction.still < model.parameters().still_cycles;
    // Any basis of the tangential plane, computed without cancellation.
    const Vec3& n = contact.normal;
    contact.tangent[0] =
        (std::fabs(n.x()) < 0.7 ? Vec3(0.0, -n.z(), n.y()) : Vec3(-n.z(), 0.0, n.x())).normalized();
    contact.tangent[1] = n.cross(contact.tangent[0]);
    const double per_rho = 1.0 / model.rotation_length();
    const auto fill = [per_rho](const Vec3& direction, const Vec3& turn, Vec<N>& out) {
      out.template head<3>() = direction;
      if constexpr (N == 6) out.template tail<3>() = turn * per_rho;
    };
    fill(n, rows.lever_cross_normal(row), contact.a);
    contact.f[0] = lambda;
    for (int k = 0; k < 2; ++k) {
      fill(contact.tangent[k], contact.lever.cross(contact.tangent[k]), contact.s[k]);
      contact.f[1 + k] = contact.tangent[k].dot(force);
    }
    contact.b = context_.sub_step.rigid.b[row] - slack_;
    contact.frictionless = frictionless;
    contact.slips = false;
    return true;
  }

  /// Finds the frictional optimum over these contacts alone.  Returns whether it was found.
  bool Solve(StepReport& report) {
    do {
      if (!Leap(kLeapSteps, report) && !Walk(report)) return false;
    } while (LetSlip());
    return true;
  }

  /// Returns t less the friction: the target of the QP over all rows.
  Vec<N> ShiftedTarget() const {
    Vec<N> t = t_;
    for (int i = 0; i < count_; ++i) t -= contact_[i].Along(contact_[i].friction());
    return t;
  }

  /// Writes the rows that carry force; returns their number.
  int Pressed(int* row) const {
    int pressed = 0;
    for (int i = 0; i < count_; ++i) {
      if (contact_[i].lambda() > 0.0) row[pressed++] = contact_[i].row;
    }
    return pressed;
  }

  bool Agrees(const double* x) const { return Largest(Vec<N>::Map(x) - x_) <= kAgreed * size_; }

  /// Takes over the normal forces of the QP, and projects friction into its cones.  Returns whether
  /// that changed anything, so that the QP must be solved again.
  bool DrawIn(const QpResult& qp) {
    bool drawn = false;
    for (int i = 0; i < count_; ++i) {
      Contact& contact = contact_[i];
      contact.f[0] = MultiplierOf(qp, contact.row);
      const double limit = contact.mu() * contact.lambda();
      const double length = contact.friction().norm();
      if (length <= limit + kBalanced * size_) continue;
      contact.f.template tail<2>() *= limit / length;
      drawn = true;
    }
    Drop([](const Contact& c) { return c.lambda() == 0.0; }, count_);
    for (int j = 0; j < qp.active; ++j) Add(qp.row[j], 0.0, qp.multiplier[j], Vec3::Zero());
    return drawn;
  }

  bool slides() const {
    return std::any_of(contact_, contact_ + count_,
                       [this](const Contact& c) { return Slides(c) && c.mu_s > 0.0; });
  }

  /// Returns what v must compensate so that a sticking point stays in place when the tool turns
  /// about it by a finite angle, as the mean over the sticking points.  Otherwise a stylus that
  /// trembles about its tip would creep by the second order.
  Vec3 Creep(const Vec3& phi) const {
    Vec3 sum = Vec3::Zero();
    int sticking = 0;
    const Quat turn = RotationExp(phi);
    for (int i = 0; i < count_; ++i) {
      const Contact& contact = contact_[i];
      if (Slides(contact) || contact.lambda() == 0.0 || contact.mu_s == 0.0) continue;
      const Vec3 rest = turn * contact.lever - contact.lever - phi.cross(contact.lever);
      sum += rest - rest.dot(contact.normal) * contact.normal;
      ++sticking;
    }
    return sticking == 0 ? sum : Vec3(sum / sticking);
  }

  /// Writes the contacts that carry force.
  void Write(FrictionState& state, QpResult& qp, FrictionForces& forces) const {
    qp.active = 0;
    for (int i = 0; i < count_; ++i) {
      const Contact& contact = contact_[i];
      if (contact.f.isZero(0.0)) continue;
      const auto k = static_cast<std::size_t>(qp.active++);
      qp.row[k] = contact.row;
      qp.multiplier[k] = std::max(0.0, contact.lambda());  // may be slightly negative by rounding
      forces[k] = -contact.f[1] * contact.tangent[0] - contact.f[2] * contact.tangent[1];
      state.id[k] = context_.buffers.rows.id(contact.row);
      state.normal_force[k] = qp.multiplier[k];
      state.force[k] = -forces[k];
    }
    state.contacts = qp.active;
  }

 private:
  struct Contact {
    /// Its row a . x >= b, and its slip (s[0] . x, s[1] . x) along two tangents.
    int row;
    Vec3 normal, lever, tangent[2];
    Vec<N> a, s[2];
    double b;
    double mu_s, mu_d;
    bool sliding = false;  ///< whether mu_d applies
    double frictionless;   ///< lambda without friction
    /// lambda, the row's multiplier, and the force that opposes the slip.
    Vec3 f;
    // In one step of either method:
    bool presses = false, slips = false;  ///< slips: friction is at its limit
    double limit;                         ///< of friction
    Vec2 direction;                       ///< if it slips: unit vector along u,
    double ratio;                         ///< and limit / |u|
    Vec<N> across;
    double base, stiffness;

    double mu() const { return sliding ? mu_d : mu_s; }
    double lambda() const { return f[0]; }
    Vec2 friction() const { return f.template tail<2>(); }
    Vec2 SlipAt(const Vec<N>& x) const { return {Dot(s[0], x), Dot(s[1], x)}; }
    /// The row of the slip along d, and of a force d: the tool feels its opposite.
    Vec<N> Along(const Vec2& d) const { return d[0] * s[0] + d[1] * s[1]; }
    Vec2 Beside() const { return {-direction[1], direction[0]}; }
  };

  bool Slides(const Contact& contact) const {
    return contact.slips && contact.lambda() != 0.0 && contact.SlipAt(x_).norm() > kSlid * size_;
  }

  /// Removes the first `most` contacts that `is` selects.
  template <class Pick>
  void Drop(Pick is, int most) {
    int kept = 0;
    for (int i = 0; i < count_; ++i) {
      if (most > 0 && is(contact_[i])) {
        --most;
      } else {
        contact_[kept++] = contact_[i];
      }
    }
    count_ = kept;
  }

  /// Returns u projected onto the disk of the contact's limit; sets slips, direction and ratio.
  static Vec2 IntoDisk(Contact& contact, const Vec2& u) {
    const double length = u.norm();
    contact.slips = length > contact.limit;
    if (!contact.slips) return u;
    contact.direction = u / length;
    contact.ratio = contact.limit / length;
    return u * contact.ratio;
  }

  // Leap: Newton's method for the laws
  //   lambda = max(0, lambda + kTrial (b - a x)),
  //   f = the point of the disk of radius mu lambda nearest to f + kTrial S x,
  // with x = t + A^T lambda - S^T f.  That is Coulomb's law with the true lambda, but not a
  // minimisation: it ends in a few steps or, seldom, not at all.

  /// Determines what a contact does by its law at x; returns the error of its forces.
  double Judge(Contact& contact) const {
    const double pressure = contact.lambda() + kTrial * (contact.b - Dot(contact.a, x_));
    contact.presses = pressure > 0.0;
    Vec3 law(contact.presses ? pressure : 0.0, 0.0, 0.0);
    contact.limit = contact.mu() * law[0];
    law.template tail<2>() = IntoDisk(contact, contact.friction() + kTrial * contact.SlipAt(x_));
    return Largest(law - contact.f);
  }

  /// Solves for x and the forces with every contact in the state that Judge found.  A
  /// contact that slips pushes back by mu lambda along u, and its force turns as Newton's
  /// step for the disk says.
  void LeapStep() {
    LinearSystem<N> system(t_);
    for (int i = 0; i < count_; ++i) {
      Contact& contact = contact_[i];
      const double pressure = contact.lambda() + kPenalty * contact.b;
      if (!contact.slips) {
        for (int k = 0; k < 2; ++k) {
          system.Add(contact.s[k], contact.f[1 + k], kPenalty, contact.s[k]);
        }
        if (contact.presses) system.Add(contact.a, -pressure, kPenalty, contact.a);
      } else if (contact.presses) {
        const Vec2& d = contact.direction;
        system.Add(contact.Along(-contact.mu() * d) + contact.a, -pressure, kPenalty, contact.a);

        contact.across = contact.Along(contact.Beside());
        const double left = std::max(1.0 - contact.ratio, contact.ratio * kTrial / kPenalty);
        contact.stiffness = contact.ratio * kTrial / left;
        const double f = d[0] * contact.f[2] - d[1] * contact.f[1];
        contact.base = f - f / left - contact.stiffness * Dot(contact.across, x_);
        system.Add(contact.across, contact.base, contact.stiffness, contact.across);
      }
    }
    x_ = system.Solve();
    for (int i = 0; i < count_; ++i) {
      Contact& contact = contact_[i];
      double& lambda = contact.f[0];
      auto friction = contact.f.template tail<2>();
      lambda = contact.presses ? lambda + kPenalty * (contact.b - Dot(contact.a, x_)) : 0.0;
      if (!contact.slips) {
        friction += kPenalty * contact.SlipAt(x_);
      } else if (contact.presses) {
        const double across = contact.base + contact.stiffness * Dot(contact.across, x_);
        friction = contact.mu() * lambda * contact.direction + across * contact.Beside();
      } else {
        friction.setZero();
      }
    }
  }

  /// Computes the x that balances the forces.
  void Balance() {
    x_ = ShiftedTarget();
    for (int i = 0; i < count_; ++i) x_ += contact_[i].a * contact_[i].lambda();
  }

  double JudgeAll() {
    double most = 0.0;
    for (int i = 0; i < count_; ++i) most = std::max(most, Judge(contact_[i]));
    return most;
  }

  /// A step whose error is greater than in each of the last three is halved; x and forces
  /// are scaled together, so that they stay in balance.  If two contacts hold the tool
  /// between them, rows and sticking contradict each other by the rounding of the gaps; then
  /// kNear is the best possible.
  bool Leap(int steps, StepReport& report) {
    Balance();
    double missed = JudgeAll(), before[3] = {};
    for (int step = 0; missed > kLeapt * size_; ++step) {
      if (step == steps) return missed <= kNear * size_;
      ++report.friction_iterations;
      before[step % 3] = missed;
      const double bound = std::max({before[0], before[1], before[2]});
      const Vec<N> old_x = x_;
      Vec3 old[kMaxActiveRows];
      for (int i = 0; i < count_; ++i) old[i] = contact_[i].f;
      const auto shorten = [&](double part) {
        x_ = old_x + part * (x_ - old_x);
        for (int i = 0; i < count_; ++i) {
          contact_[i].f = old[i] + part * (contact_[i].f - old[i]);
        }
        return JudgeAll();
      };
      const double last = missed;
      LeapStep();
      missed = JudgeAll();
      if (last <= kNear * size_ && missed >= last) {
        shorten(0.0);
        return true;
      }
      for (int halving = 0; missed >= bound && halving < kHalvings; ++halving) {
        missed = shorten(0.5);
      }
    }
    return true;
  }

  // Walk: used when Leap fails (friction.md).  Limits that follow lambda stay below the load of all
  // contacts together.

  /// Computes the forces at x for the penalty c into `at`, by the laws of the contacts; returns the
  /// gradient.
  Vec<N> Gradient(const Vec<N>& x, double c, Contact* at) const {
    Vec<N> g = x - t_;
    for (int i = 0; i < count_; ++i) {
      const Contact& contact = contact_[i];
      Contact& now = at[i];
      now.f[0] = std::max(0.0, contact.lambda() + c * (contact.b - Dot(contact.a, x)));
      now.f.template tail<2>() = IntoDisk(now, contact.friction() + c * contact.SlipAt(x));
      g += contact.Along(now.friction()) - contact.a * now.lambda();
    }
    return g;
  }

  /// Newton's method.  A step that overshoots is shortened by the secant of its slope, which always
  /// leads down in a convex function.
  bool Minimise(double c, Contact* at, StepReport& report) {
    Vec<N> g = Gradient(x_, c, at);
    for (int step = 0; step < kWalkSteps; ++step) {
      if (Largest(g) <= kBalanced * size_) return true;
      ++report.friction_iterations;
      LinearSystem<N> system(-g);
      for (int i = 0; i < count_; ++i) {
        const Contact& now = at[i];
        if (now.lambda() > 0.0) system.Add(now.a, 0.0, c, now.a);
        if (now.slips) {
          const Vec<N> across = now.Along(now.Beside());
          system.Add(across, 0.0, c * now.ratio, across);
        } else {
          for (int k = 0; k < 2; ++k) system.Add(now.s[k], 0.0, c, now.s[k]);
        }
      }
      const Vec<N> d = system.Solve(), from = x_;
      const double slope = Dot(g, d);
      double part = 1.0;
      for (int shorter = 0;; ++shorter) {
        x_ = from + part * d;
        g = Gradient(x_, c, at);
        const double next_slope = Dot(g, d);
        if (next_slope <= -0.5 * slope || shorter == kShorter) break;
        part *= std::max(0.1, slope / (slope - next_slope));
      }
    }
    return false;
  }

  bool Walk(StepReport& report) {
    double load = 0.0;
    for (int i = 0; i < count_; ++i) {
      Contact& contact = contact_[i];
      load += contact.frictionless;
      contact.f = {contact.frictionless, 0.0, 0.0};
      contact.limit = contact.mu() * contact.lambda();
    }
    Balance();
    Contact at[kMaxActiveRows];
    double c = 1.0;
    for (int update = 0; update < kWalkUpdates; ++update) {
      std::copy(contact_, contact_ + count_, at);
      if (update == kWalkRaises) {
        const Vec<N> x = x_;
        if (Leap(kSecondLeap, report)) return true;
        x_ = x;
        std::copy(at, at + count_, contact_);
        ++report.friction_lowered;
      }
      const bool balanced = Minimise(c, at, report);
      double most = 0.0;
      for (int i = 0; i < count_; ++i) {
        Contact& contact = contact_[i];
        const double moved = Largest(at[i].f - contact.f);
        contact = at[i];
        const double limit = contact.mu() * contact.lambda();
        const double highest = update < kWalkRaises ? contact.mu() * load : contact.limit;
        const double next = std::min(limit, highest);
        most = std::max({most, moved / c, std::fabs(next - contact.limit)});
        contact.limit = next;
      }
      if (balanced && most <= kWalked * size_) return true;
      if (report.friction_iterations >= kCycleSteps) return false;
      c = std::min(10.0 * c, kWalkPenalty);
    }
    return false;
  }

  /// Gives mu_d to the contacts that mu_s does not hold; returns whether that changes anything.
  bool LetSlip() {
    bool any = false;
    for (int i = 0; i < count_; ++i) {
      Contact& contact = contact_[i];
      if (contact.sliding || !Slides(contact)) continue;
      contact.sliding = true;
      any = any || contact.mu_d != contact.mu_s;
    }
    return any;
  }

  const StepContext& context_;
  double slack_;
  Vec<N> t_, x_;
  double size_;  ///< of the problem: tolerances are relative to it
  int count_ = 0;
  Contact contact_[kMaxActiveRows];
};

/// Collects the contacts of the last sub-step that are still near, with their forces, and those of
/// the frictionless optimum.  If there are any of the former, the others start without force,
/// because the former balanced the hand.
template <int N>
void AddContacts(const StepContext& context, const QpResult& qp, FrictionalContacts<N>& contacts) {
  const FrictionState& state = context.state.friction;
  for (int i = 0; i < state.contacts; ++i) {
    const auto k = static_cast<std::size_t>(i);
    int row;
    if (context.buffers.rows.Find({&state.id[k], 1}, &row) == 1) {
      contacts.Add(row, MultiplierOf(qp, row), state.normal_force[k], state.force[k]);
    }
  }
  const bool warm = contacts.count() > 0;
  for (int i = 0; i < qp.active; ++i) {
    contacts.Add(qp.row[i], qp.multiplier[i], warm ? 0.0 : qp.multiplier[i], Vec3::Zero());
  }
}

/// Returns false if the frictionless optimum stays.
/// @param t  the target, N values
template <int N>
bool Solve(StepContext& context, Optimum& optimum, const double* t) {
  StepReport& report = context.report;
  QpResult& qp = optimum.qp;
  FrictionalContacts<N> contacts(context, optimum, t);
  AddContacts(context, qp, contacts);
  QpResult shifted;
  const auto solve_shifted = [&] {
    int guess[kMaxActiveRows];
    const int guesses = contacts.Pressed(guess);
    shifted = context.kernels.solve(contacts.ShiftedTarget().data(), N, context.sub_step.rigid,
                                    guess, guesses);
    report.qp_iterations += shifted.iterations;
    return shifted.status != QpStatus::kIterationLimit;
  };
  bool solved = false, added = true;
  for (int round = 0; round < kRounds && added && !solved; ++round) {
    const bool found = contacts.Solve(report);
    if (!solve_shifted()) return false;
    added = false;
    for (int i = 0; i < shifted.active; ++i) {
      added |= contacts.Add(shifted.row[i], 0.0, 0.0, Vec3::Zero());
    }
    // If the QP's solution rests on these contacts alone, both have found the same x.
    solved = found && (!added || contacts.Agrees(shifted.x));
  }
  report.friction_unsolved += !solved;
  for (int draw = 0; !solved && contacts.DrawIn(shifted); ++draw) {
    if (draw == kDraws || !solve_shifted()) return false;
  }
  if (contacts.slides()) context.state.friction.still = 0;
  std::copy(shifted.x, shifted.x + N, qp.x);
  contacts.Write(context.state.friction, qp, optimum.friction);
  if constexpr (N == 6) {
    const Vec3 phi = Vec3::Map(qp.x + 3) / context.model.rotation_length();
    if (phi.norm() <= context.model.parameters().max_rotation) {
      Vec3::Map(qp.x) -= contacts.Creep(phi);
    }
  }
  return true;
}

}  // namespace

void AddCoulombFriction(StepContext& context, Optimum& optimum) noexcept {
  FrictionState& state = context.state.friction;
  if (context.report.substeps == 0 && state.still < context.model.parameters().still_cycles) {
    ++state.still;
  }
  const double rho = context.model.rotation_length();
  // The push of soft contacts is taken as it is without friction.
  const Vec3 v = context.sub_step.target.v + optimum.push;
  const Vec3 phi = context.sub_step.target.phi + optimum.push_turn / (rho * rho);
  Vec6 t;
  t << v, rho * phi;
  const bool turns = context.model.degrees_of_freedom() == 6;
  optimum.rubs = true;
  if (!(turns ? Solve<6>(context, optimum, t.data()) : Solve<3>(context, optimum, t.data()))) {
    for (Vec3& force : optimum.friction) force.setZero();
    state.contacts = 0;
  }
  optimum.Take(turns ? Vec3(Vec3::Map(optimum.qp.x + 3) / rho) : optimum.phi);
}

}  // namespace palpate
