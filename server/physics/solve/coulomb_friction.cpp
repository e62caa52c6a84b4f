#include <algorithm>
#include <cmath>

#include "common/math/rotation.h"
#include "server/physics/limits.h"
#include "server/physics/solve/friction.h"
#include "server/physics/solve/linear_system.h"

namespace palpate {

namespace {

using namespace limits::friction;

template <int N>
double Dot(const double (&a)[N], const double (&b)[N]) {
  double sum = 0.0;
  for (int c = 0; c < N; ++c) sum += a[c] * b[c];
  return sum;
}

/// The contacts of a sub-step, and two methods that find their forces.  Lengths in metres, and
/// forces too, divided by k_t.
template <int N>
class FrictionalContacts {
 public:
  /// @param t  the target, N values
  FrictionalContacts(const StepContext& context, const Optimum& frictionless, const double* t)
      : context_(context), slack_(frictionless.qp.slack) {
    const QpResult& qp = frictionless.qp;
    double tt = 0.0, moved = 0.0;
    for (int c = 0; c < N; ++c) {
      t_[c] = t[c];
      tt += t[c] * t[c];
      moved += (t[c] - qp.x[c]) * (t[c] - qp.x[c]);
    }
    size_ = std::sqrt(tt) + std::sqrt(moved);
  }

  int count() const { return count_; }

  /// Adds a contact.  Returns false if the row is there already, or there is no room.
  /// @param frictionless, lambda, force  from its optimum: where Newton's method starts
  bool Add(int row, double frictionless, double lambda, const Vec3& force) {
    for (int i = 0; i < count_; ++i) {
      if (contact_[i].row == row) return false;
    }
    if (count_ == kMaxActiveRows) Drop([](const Contact& c) { return c.lambda == 0.0; }, 1);
    if (count_ == kMaxActiveRows) return false;
    const HapticModel& model = context_.model;
    const ContactRows& rows = context_.buffers.rows;
    Contact& contact = contact_[count_++];
    contact.row = row;
    contact.normal = rows.normal(row);
    const Material& material = model.MaterialOf(rows.id(row), context_.state.felt);
    contact.lever = rows.LeverOf(row, model.tool().leaves(), context_.tools.R_WG);
    contact.mu_s = material.static_friction;
    contact.mu_d = material.dynamic_friction;
    contact.sliding = context_.state.friction.still < model.parameters().still_cycles;
    // Any basis of the tangential plane, computed without cancellation.
    const Vec3& n = contact.normal;
    contact.tangent[0] =
        (std::fabs(n.x()) < 0.7 ? Vec3(0.0, -n.z(), n.y()) : Vec3(-n.z(), 0.0, n.x())).normalized();
    contact.tangent[1] = n.cross(contact.tangent[0]);
    const double per_rho = 1.0 / model.rotation_length();
    const auto fill = [per_rho](const Vec3& direction, const Vec3& turn, double* out) {
      for (int c = 0; c < 3; ++c) {
        out[c] = direction[c];
        if constexpr (N == 6) out[3 + c] = turn[c] * per_rho;
      }
    };
    fill(n, rows.lever_cross_normal(row), contact.a);
    for (int k = 0; k < 2; ++k) {
      fill(contact.tangent[k], contact.lever.cross(contact.tangent[k]), contact.s[k]);
      contact.force[k] = contact.tangent[k].dot(force);
    }
    contact.b = context_.sub_step.rigid.b[row] - slack_;
    contact.frictionless = frictionless;
    contact.lambda = lambda;
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
  void ShiftedTarget(double* t) const {
    for (int c = 0; c < N; ++c) {
      t[c] = t_[c];
      for (int i = 0; i < count_; ++i) {
        const Contact& contact = contact_[i];
        t[c] -= contact.s[0][c] * contact.force[0] + contact.s[1][c] * contact.force[1];
      }
    }
  }

  /// Writes the rows that carry force; returns their number.
  int Pressed(int* row) const {
    int pressed = 0;
    for (int i = 0; i < count_; ++i) {
      if (contact_[i].lambda > 0.0) row[pressed++] = contact_[i].row;
    }
    return pressed;
  }

  bool Agrees(const double* x) const {
    double most = 0.0;
    for (int c = 0; c < N; ++c) most = std::max(most, std::fabs(x[c] - x_[c]));
    return most <= kAgreed * size_;
  }

  /// Takes over the normal forces of the QP, and projects friction into its cones.  Returns whether
  /// that changed anything, so that the QP must be solved again.
  bool DrawIn(const QpResult& qp) {
    bool drawn = false;
    for (int i = 0; i < count_; ++i) {
      Contact& contact = contact_[i];
      contact.lambda = 0.0;
      for (int j = 0; j < qp.active; ++j) {
        if (qp.row[j] == contact.row) contact.lambda = qp.multiplier[j];
      }
      const double limit = contact.mu() * contact.lambda;
      const double length = contact.friction();
      if (length <= limit + kBalanced * size_) continue;
      const double part = limit / length;
      contact.force[0] *= part;
      contact.force[1] *= part;
      drawn = true;
    }
    Drop([](const Contact& c) { return c.lambda == 0.0; }, count_);
    for (int j = 0; j < qp.active; ++j) Add(qp.row[j], 0.0, qp.multiplier[j], Vec3::Zero());
    return drawn;
  }

  bool slides() const {
    return std::any_of(contact_, contact_ + count_,
                       [this](const Contact& c) { return Slides(c) && c.mu_s > 0.0; });
  }

  /// Keeps a sticking point in place when the tool turns about it by a finite angle, not just
  /// to first order: returns what v must compensate, as the mean over the sticking points.
  /// Otherwise a stylus that trembles about its tip would creep by the second order, always
  /// in the same direction.
  Vec3 Creep(const Vec3& phi) const {
    Vec3 sum = Vec3::Zero();
    int sticking = 0;
    const Quat turn = RotationExp(phi);
    for (int i = 0; i < count_; ++i) {
      const Contact& contact = contact_[i];
      if (Slides(contact) || contact.lambda == 0.0 || contact.mu_s == 0.0) continue;
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
      if (contact.lambda == 0.0 && contact.friction() == 0.0) continue;
      const auto k = static_cast<std::size_t>(qp.active++);
      qp.row[k] = contact.row;
      qp.multiplier[k] = std::max(0.0, contact.lambda);  // may be slightly negative by rounding
      forces[k] = -contact.force[0] * contact.tangent[0] - contact.force[1] * contact.tangent[1];
      state.id[k] = context_.buffers.rows.id(contact.row);
      state.normal_force[k] = qp.multiplier[k];
      state.force[k] = -forces[k];
    }
    state.contacts = qp.active;
  }

 private:
  /// The geometry of a contact: its row a . x >= b, and its slip
  /// (s[0] . x, s[1] . x) along two tangents.
  struct Place {
    int row;
    Vec3 normal, lever, tangent[2];
    double a[N], s[2][N], b;
  };
  /// Its state in one step of either method.
  struct Step {
    bool presses = false;
    double limit;                ///< of friction
    double direction[2], ratio;  ///< if it slips: unit vector along u, and limit / |u|
    double across[N], base, stiffness;
  };
  /// `lambda` is the row's multiplier; `force` opposes the slip.
  struct Contact : Place, Step {
    double mu_s, mu_d;
    bool sliding = false;  ///< whether mu_d applies
    double frictionless;   ///< lambda without friction
    double lambda, force[2];
    bool slips = false;  ///< whether friction is at its limit
    double mu() const { return sliding ? mu_d : mu_s; }
    double friction() const { return std::sqrt(force[0] * force[0] + force[1] * force[1]); }
    /// Computes the row of the slip along (d0, d1).
    void Slip(double d0, double d1, double (&out)[N]) const {
      for (int c = 0; c < N; ++c) out[c] = d0 * this->s[0][c] + d1 * this->s[1][c];
    }
  };

  bool Slides(const Contact& contact) const {
    if (!contact.slips || contact.lambda == 0.0) return false;
    const double s0 = Dot(contact.s[0], x_), s1 = Dot(contact.s[1], x_);
    return std::sqrt(s0 * s0 + s1 * s1) > kSlid * size_;
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

  /// Projects u onto the disk of the contact's limit: sets slips, direction and ratio.
  static void IntoDisk(Contact& contact, double& u0, double& u1) {
    const double length = std::sqrt(u0 * u0 + u1 * u1);
    contact.slips = length > contact.limit;
    if (!contact.slips) return;
    contact.direction[0] = u0 / length;
    contact.direction[1] = u1 / length;
    contact.ratio = contact.limit / length;
    u0 *= contact.ratio;
    u1 *= contact.ratio;
  }

  // Leap: Newton's method for the laws
  //   lambda = max(0, lambda + kTrial (b - a x)),
  //   f = the point of the disk of radius mu lambda nearest to f + kTrial S x,
  // with x = t + A^T lambda - S^T f.  That is Coulomb's law with the true lambda, but not a
  // minimisation: it ends in a few steps or, seldom, not at all.

  /// Determines what a contact does by its law at x; returns the error of its forces.
  double Judge(Contact& contact) const {
    const double pressure = contact.lambda + kTrial * (contact.b - Dot(contact.a, x_));
    contact.presses = pressure > 0.0;
    const double lambda = contact.presses ? pressure : 0.0;
    contact.limit = contact.mu() * lambda;
    double f0 = contact.force[0] + kTrial * Dot(contact.s[0], x_);
    double f1 = contact.force[1] + kTrial * Dot(contact.s[1], x_);
    IntoDisk(contact, f0, f1);
    return std::max({std::fabs(lambda - contact.lambda), std::fabs(f0 - contact.force[0]),
                     std::fabs(f1 - contact.force[1])});
  }

  /// Solves for x and the forces with every contact in the state that Judge found.  A
  /// contact that slips pushes back by mu lambda along u, and its force turns as Newton's
  /// step for the disk says.
  void LeapStep() {
    LinearSystem<N> system(t_);
    for (int i = 0; i < count_; ++i) {
      Contact& contact = contact_[i];
      const double pressure = contact.lambda + kPenalty * contact.b;
      if (!contact.slips) {
        for (int k = 0; k < 2; ++k) {
          system.Add(contact.s[k], contact.force[k], kPenalty, contact.s[k]);
        }
        if (contact.presses) system.Add(contact.a, -pressure, kPenalty, contact.a);
      } else if (contact.presses) {
        const double* d = contact.direction;
        double push[N];
        contact.Slip(-contact.mu() * d[0], -contact.mu() * d[1], push);
        for (int c = 0; c < N; ++c) push[c] += contact.a[c];
        system.Add(push, -pressure, kPenalty, contact.a);

        contact.Slip(-d[1], d[0], contact.across);
        const double left = std::max(1.0 - contact.ratio, contact.ratio * kTrial / kPenalty);
        contact.stiffness = contact.ratio * kTrial / left;
        const double f = d[0] * contact.force[1] - d[1] * contact.force[0];
        contact.base = f - f / left - contact.stiffness * Dot(contact.across, x_);
        system.Add(contact.across, contact.base, contact.stiffness, contact.across);
      }
    }
    system.Solve(x_);
    for (int i = 0; i < count_; ++i) {
      Contact& contact = contact_[i];
      contact.lambda =
          contact.presses ? contact.lambda + kPenalty * (contact.b - Dot(contact.a, x_)) : 0.0;
      if (!contact.slips) {
        for (int k = 0; k < 2; ++k) contact.force[k] += kPenalty * Dot(contact.s[k], x_);
      } else if (contact.presses) {
        const double* d = contact.direction;
        const double along = contact.mu() * contact.lambda;
        const double across = contact.base + contact.stiffness * Dot(contact.across, x_);
        contact.force[0] = d[0] * along - d[1] * across;
        contact.force[1] = d[1] * along + d[0] * across;
      } else {
        contact.force[0] = contact.force[1] = 0.0;
      }
    }
  }

  /// Computes the x that balances the forces.
  void Balance() {
    ShiftedTarget(x_);
    for (int i = 0; i < count_; ++i) {
      for (int c = 0; c < N; ++c) x_[c] += contact_[i].a[c] * contact_[i].lambda;
    }
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
      double old_x[N], old_lambda[kMaxActiveRows], old_force[kMaxActiveRows][2];
      std::copy(x_, x_ + N, old_x);
      for (int i = 0; i < count_; ++i) {
        old_lambda[i] = contact_[i].lambda;
        std::copy(contact_[i].force, contact_[i].force + 2, old_force[i]);
      }
      const auto shorten = [&](double part) {
        const auto blend = [part](double& value, double old) {
          value = old + part * (value - old);
        };
        for (int c = 0; c < N; ++c) blend(x_[c], old_x[c]);
        for (int i = 0; i < count_; ++i) {
          blend(contact_[i].lambda, old_lambda[i]);
          for (int k = 0; k < 2; ++k) blend(contact_[i].force[k], old_force[i][k]);
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

  // Walk: used when Leap fails, also when there may be no solution (a tool wedged deeper than its
  // friction lets it out: the normal forces grow without bound).  With fixed limits the problem is
  // convex, and the minimum of the augmented Lagrangian is sure to be found.  The limits are first
  // those of the frictionless lambda, then follow the lambda that they give (none above the load of
  // all contacts together), and in the end are only lowered, until each force lies in its cone.

  /// Computes the forces at x for the penalty c into `at`, by the laws of the contacts,
  /// and the gradient g.
  void Gradient(const double (&x)[N], double c, Contact* at, double (&g)[N]) const {
    for (int r = 0; r < N; ++r) g[r] = x[r] - t_[r];
    for (int i = 0; i < count_; ++i) {
      const Contact& contact = contact_[i];
      Contact& now = at[i];
      now.lambda = std::max(0.0, contact.lambda + c * (contact.b - Dot(contact.a, x)));
      for (int k = 0; k < 2; ++k) now.force[k] = contact.force[k] + c * Dot(contact.s[k], x);
      IntoDisk(now, now.force[0], now.force[1]);
      for (int r = 0; r < N; ++r) {
        g[r] += contact.s[0][r] * now.force[0] + contact.s[1][r] * now.force[1] -
                contact.a[r] * now.lambda;
      }
    }
  }

  /// Newton's method.  A step that overshoots is shortened by the secant of its slope, which always
  /// leads down in a convex function.
  bool Minimise(double c, Contact* at, StepReport& report) {
    double g[N], d[N], next[N], next_g[N];
    Gradient(x_, c, at, g);
    for (int step = 0; step < kWalkSteps; ++step) {
      double most = 0.0;
      for (int r = 0; r < N; ++r) most = std::max(most, std::fabs(g[r]));
      if (most <= kBalanced * size_) return true;
      ++report.friction_iterations;
      for (int r = 0; r < N; ++r) d[r] = -g[r];
      LinearSystem<N> system(d);
      for (int i = 0; i < count_; ++i) {
        const Contact& now = at[i];
        if (now.lambda > 0.0) system.Add(now.a, 0.0, c, now.a);
        if (now.slips) {
          double across[N];
          now.Slip(-now.direction[1], now.direction[0], across);
          system.Add(across, 0.0, c * now.ratio, across);
        } else {
          for (int k = 0; k < 2; ++k) system.Add(now.s[k], 0.0, c, now.s[k]);
        }
      }
      system.Solve(d);
      const double slope = Dot(g, d);
      double part = 1.0;
      for (int shorter = 0;; ++shorter) {
        for (int r = 0; r < N; ++r) next[r] = x_[r] + part * d[r];
        Gradient(next, c, at, next_g);
        const double next_slope = Dot(next_g, d);
        if (next_slope <= -0.5 * slope || shorter == kShorter) break;
        part *= std::max(0.1, slope / (slope - next_slope));
      }
      std::copy(next, next + N, x_);
      std::copy(next_g, next_g + N, g);
    }
    return false;
  }

  bool Walk(StepReport& report) {
    double load = 0.0;
    for (int i = 0; i < count_; ++i) {
      Contact& contact = contact_[i];
      load += contact.frictionless;
      contact.lambda = contact.frictionless;
      contact.limit = contact.mu() * contact.lambda;
      contact.force[0] = contact.force[1] = 0.0;
    }
    Balance();
    Contact at[kMaxActiveRows];
    double c = 1.0;
    for (int update = 0; update < kWalkUpdates; ++update) {
      std::copy(contact_, contact_ + count_, at);
      if (update == kWalkRaises) {
        double x[N];
        std::copy(x_, x_ + N, x);
        if (Leap(kSecondLeap, report)) return true;
        std::copy(x, x + N, x_);
        std::copy(at, at + count_, contact_);
        ++report.friction_lowered;
      }
      const bool balanced = Minimise(c, at, report);
      double most = 0.0;
      for (int i = 0; i < count_; ++i) {
        Contact& contact = contact_[i];
        const double moved = std::max({std::fabs(at[i].lambda - contact.lambda),
                                       std::fabs(at[i].force[0] - contact.force[0]),
                                       std::fabs(at[i].force[1] - contact.force[1])});
        contact = at[i];
        const double limit = contact.mu() * contact.lambda;
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
  double t_[N], x_[N];
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
  const auto frictionless = [&](int row) {
    const int* found = std::find(qp.row, qp.row + qp.active, row);
    return found == qp.row + qp.active ? 0.0 : qp.multiplier[found - qp.row];
  };
  for (int i = 0; i < state.contacts; ++i) {
    const auto k = static_cast<std::size_t>(i);
    int row;
    if (context.buffers.rows.Find({&state.id[k], 1}, &row) == 1) {
      contacts.Add(row, frictionless(row), state.normal_force[k], state.force[k]);
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
    double target[N];
    int guess[kMaxActiveRows];
    contacts.ShiftedTarget(target);
    const int guesses = contacts.Pressed(guess);
    shifted = context.kernels.solve(target, N, context.sub_step.rigid, guess, guesses);
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
    const Vec3 phi = Vec3(qp.x[3], qp.x[4], qp.x[5]) / context.model.rotation_length();
    if (phi.norm() <= context.model.parameters().max_rotation) {
      const Vec3 creep = contacts.Creep(phi);
      for (int c = 0; c < 3; ++c) qp.x[c] -= creep[c];
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
  const double t[6] = {v.x(), v.y(), v.z(), rho * phi.x(), rho * phi.y(), rho * phi.z()};
  const bool turns = context.model.degrees_of_freedom() == 6;
  optimum.rubs = true;
  if (!(turns ? Solve<6>(context, optimum, t) : Solve<3>(context, optimum, t))) {
    for (Vec3& force : optimum.friction) force.setZero();
    state.contacts = 0;
  }
  const double* x = optimum.qp.x;
  optimum.v = Vec3(x[0], x[1], x[2]);
  if (turns) optimum.phi = Vec3(x[3], x[4], x[5]) / rho;
  optimum.RefuseNaN();
}

}  // namespace palpate
