#include "server/physics/friction.h"

#include <algorithm>
#include <cmath>

#include "common/math/rotation.h"
#include "server/physics/sphere_tree_query.h"

namespace palpate {

ContactPlace PlaceOf(const HapticModel& model, const LeafPair& pair, const Vec3& normal,
                     const Mat3& R_WG) noexcept {
  const LeafSphere& leaf = model.tool().leaves()[static_cast<std::size_t>(pair.tool)];
  return {R_WG * Vec3(leaf.x, leaf.y, leaf.z) - leaf.radius * normal,
          &model.objects().MaterialOf(pair.object)};
}

namespace {

/// c of the augmented Lagrangian, as a ratio to k_t.  Each Newton step divides what rows and
/// sticking contacts still miss by about this; its square must not reach 1 / epsilon.
constexpr double kPenalty = 1e5;
/// The same where it only decides whether a contact presses and slips: about the inverse of how far
/// a unit force moves a contact, which is where Newton's method jumps about least.
constexpr double kTrial = 1.0;
constexpr int kNewtonSteps = 30;  ///< per set of contacts and of coefficients
constexpr int kRounds = 6;        ///< of QP over all rows and Newton over the contacts
/// Relative to the size of the problem: what the forces still miss of their laws; the QP's optimum
/// against Newton's.
constexpr double kConverged = 1e-10, kAgreed = 1e-9;

/// x := H^-1 x by elimination with row exchanges.
template <int N>
void SolveLinear(double (&H)[N][N], double (&x)[N]) {
  for (int k = 0; k < N; ++k) {
    int pivot = k;
    for (int i = k + 1; i < N; ++i) {
      if (std::fabs(H[i][k]) > std::fabs(H[pivot][k])) pivot = i;
    }
    if (pivot != k) {
      std::swap(H[pivot], H[k]);
      std::swap(x[pivot], x[k]);
    }
    const double inverse = 1.0 / H[k][k];
    for (int i = k + 1; i < N; ++i) {
      const double part = H[i][k] * inverse;
      for (int j = k + 1; j < N; ++j) H[i][j] -= part * H[k][j];
      x[i] -= part * x[k];
    }
  }
  for (int k = N - 1; k >= 0; --k) {
    for (int j = k + 1; j < N; ++j) x[k] -= H[k][j] * x[j];
    x[k] /= H[k][k];
  }
}

template <int N>
double Dot(const double (&a)[N], const double (&b)[N]) {
  double sum = 0.0;
  for (int c = 0; c < N; ++c) sum += a[c] * b[c];
  return sum;
}

/// The contacts of a sub-step and Newton's method over them.  Lengths in metres; forces too (over
/// k_t).
template <int N>
class FrictionalContacts {
 public:
  FrictionalContacts(const HapticModel& model, const Mat3& R_WG, const ContactRows& rows,
                     const double* t, const QpResult& qp, bool still)
      : model_(model), R_WG_(R_WG), rows_(rows), slack_(qp.slack), still_(still) {
    double tt = 0.0, moved = 0.0;
    for (int c = 0; c < N; ++c) {
      t_[c] = t[c];
      x_[c] = qp.x[c];
      tt += t[c] * t[c];
      moved += (t[c] - qp.x[c]) * (t[c] - qp.x[c]);
    }
    size_ = std::sqrt(tt) + std::sqrt(moved);
  }

  int count() const { return count_; }
  const double* x() const { return x_; }

  /// False where there is no room, or it is there already.
  bool Add(int row, double lambda, const Vec3& force) {
    for (int i = 0; i < count_; ++i) {
      if (contact_[i].row == row) return false;
    }
    if (count_ == kMaxActiveRows && !DropIdle()) return false;
    Contact& contact = contact_[count_++];
    contact.row = row;
    contact.normal = rows_.normal(row);
    const ContactPlace place = PlaceOf(model_, rows_.pair(row), contact.normal, R_WG_);
    contact.lever = place.lever;
    contact.mu_s = place.material->static_friction;
    contact.mu_d = place.material->dynamic_friction;
    contact.sliding = !still_;
    // Any basis of the tangential plane, free of cancellation.
    const Vec3& n = contact.normal;
    const Vec3 t1 = (std::fabs(n.x()) < 0.7 ? Vec3(0.0, -n.z(), n.y()) : Vec3(-n.z(), 0.0, n.x()))
                        .normalized();
    contact.tangent[0] = t1;
    contact.tangent[1] = n.cross(t1);
    const double rho = model_.rotation_length();
    const auto fill = [&](const Vec3& direction, const Vec3& turn, double* out) {
      for (int c = 0; c < 3; ++c) {
        out[c] = direction[c];
        if constexpr (N == 6) out[3 + c] = turn[c] / rho;
      }
    };
    fill(n, rows_.lever_cross_normal(row), contact.a);
    for (int k = 0; k < 2; ++k) {
      fill(contact.tangent[k], contact.lever.cross(contact.tangent[k]), contact.s[k]);
      contact.force[k] = contact.tangent[k].dot(force);
    }
    contact.b = -rows_.gap(row) - slack_;
    contact.lambda = lambda;
    return true;
  }

  /// The frictional optimum over the contacts alone.  False where it does not converge.
  bool Solve(StepReport& report) {
    bool converged = Converge(report);
    while (converged && LetSlip()) converged = Converge(report);
    return converged;
  }

  /// t less the friction: the QP's target.
  void ShiftedTarget(double* t) const {
    for (int c = 0; c < N; ++c) {
      t[c] = t_[c];
      for (int i = 0; i < count_; ++i) {
        const Contact& contact = contact_[i];
        t[c] -= contact.s[0][c] * contact.force[0] + contact.s[1][c] * contact.force[1];
      }
    }
  }

  bool Agrees(const double* x) const {
    double most = 0.0;
    for (int c = 0; c < N; ++c) most = std::max(most, std::fabs(x[c] - x_[c]));
    return most <= kAgreed * size_;
  }

  bool slips() const {
    for (int i = 0; i < count_; ++i) {
      if (contact_[i].slips && contact_[i].mu_s > 0.0) return true;
    }
    return false;
  }

  /// Mean over the sticking contacts of what a rotation's second order would make them creep.
  Vec3 Creep(const Vec3& phi) const {
    Vec3 sum = Vec3::Zero();
    int sticking = 0;
    const Quat turn = RotationExp(phi);
    for (int i = 0; i < count_; ++i) {
      const Contact& contact = contact_[i];
      if (contact.slips || !(contact.lambda > 0.0) || !(contact.mu_s > 0.0)) continue;
      const Vec3 rest = turn * contact.lever - contact.lever - phi.cross(contact.lever);
      sum += rest - rest.dot(contact.normal) * contact.normal;
      ++sticking;
    }
    return sticking == 0 ? sum : Vec3(sum / sticking);
  }

  /// Takes the normal forces of the QP, where Newton's method has not found them.
  void TakeNormalForces(const QpResult& qp) {
    for (int i = 0; i < count_; ++i) {
      contact_[i].lambda = 0.0;
      for (int j = 0; j < qp.active; ++j) {
        if (qp.row[j] == contact_[i].row) contact_[i].lambda = qp.multiplier[j];
      }
    }
  }

  /// The contacts that carry force.
  void Write(FrictionState& state, QpResult& qp, FrictionForces& forces) const {
    qp.active = 0;
    for (int i = 0; i < count_; ++i) {
      const Contact& contact = contact_[i];
      if (contact.lambda == 0.0 && contact.force[0] == 0.0 && contact.force[1] == 0.0) continue;
      const auto k = static_cast<std::size_t>(qp.active);
      qp.row[k] = contact.row;
      qp.multiplier[k] = contact.lambda;
      forces[k] = -contact.force[0] * contact.tangent[0] - contact.force[1] * contact.tangent[1];
      state.pair[k] = rows_.pair(contact.row);
      state.normal_force[k] = contact.lambda;
      state.force[k] = -forces[k];
      ++qp.active;
    }
    state.contacts = qp.active;
  }

 private:
  /// f: force against the tool's slip, along the two tangents.
  struct Contact {
    int row;
    bool sliding;  ///< mu_d
    bool slips;    ///< its friction is at its limit
    double mu_s, mu_d, b;
    double a[N], s[2][N];
    bool pressed;
    double lambda, force[2];
    // Where it slips: direction of u, limit / |u|, and the linear law of the force across u.
    double direction[2], ratio, across[N], base, stiffness;
    Vec3 normal, lever, tangent[2];
    double mu() const { return sliding ? mu_d : mu_s; }
  };

  bool DropIdle() {
    for (int i = 0; i < count_; ++i) {
      if (contact_[i].lambda > 0.0) continue;
      for (int j = i; j + 1 < count_; ++j) contact_[j] = contact_[j + 1];
      --count_;
      return true;
    }
    return false;
  }

  /// x that the forces balance: t + A^T lambda - S^T f.
  void Balance() {
    for (int c = 0; c < N; ++c) {
      x_[c] = t_[c];
      for (int i = 0; i < count_; ++i) {
        const Contact& contact = contact_[i];
        x_[c] += contact.a[c] * contact.lambda - contact.s[0][c] * contact.force[0] -
                 contact.s[1][c] * contact.force[1];
      }
    }
  }

  /// What a contact's forces should be at x: lambda = max(0, lambda + kTrial (b - a x)), and f = the
  /// point of the disk of radius mu lambda nearest to f + kTrial S x.  Returns by how much they are
  /// not.
  double Judge(Contact& contact) const {
    const double pressed = contact.lambda + kTrial * (contact.b - Dot(contact.a, x_));
    contact.pressed = pressed > 0.0;
    const double lambda = contact.pressed ? pressed : 0.0;
    const double limit = contact.mu() * lambda;
    const double u0 = contact.force[0] + kTrial * Dot(contact.s[0], x_);
    const double u1 = contact.force[1] + kTrial * Dot(contact.s[1], x_);
    const double length = std::sqrt(u0 * u0 + u1 * u1);
    contact.slips = length > limit;
    double f0 = u0, f1 = u1;
    if (contact.slips) {
      contact.direction[0] = u0 / length;
      contact.direction[1] = u1 / length;
      contact.ratio = limit / length;
      f0 = limit * contact.direction[0];
      f1 = limit * contact.direction[1];
    }
    return std::max({std::fabs(lambda - contact.lambda), std::fabs(f0 - contact.force[0]),
                     std::fabs(f1 - contact.force[1])});
  }

  /// One step: x and the forces of the linear problem that is left when every contact stays what it
  /// was judged to be.
  void NewtonStep() {
    double H[N][N], x[N];
    for (int r = 0; r < N; ++r) {
      x[r] = t_[r];
      for (int c = 0; c < N; ++c) H[r][c] = r == c ? 1.0 : 0.0;
    }
    // A force `column` * (base + scale * row . x) on the left-hand side.
    const auto add = [&](const double* column, double base, double scale, const double* row) {
      for (int r = 0; r < N; ++r) {
        x[r] -= base * column[r];
        const double part = scale * column[r];
        for (int c = 0; c < N; ++c) H[r][c] += part * row[c];
      }
    };
    for (int i = 0; i < count_; ++i) {
      Contact& contact = contact_[i];
      if (!contact.slips) {
        add(contact.s[0], contact.force[0], kPenalty, contact.s[0]);
        add(contact.s[1], contact.force[1], kPenalty, contact.s[1]);
        if (contact.pressed) {
          add(contact.a, -(contact.lambda + kPenalty * contact.b), kPenalty, contact.a);
        }
        continue;
      }
      if (!contact.pressed) continue;
      const double mu = contact.mu();
      double push[N];
      for (int c = 0; c < N; ++c) {
        contact.across[c] =
            contact.direction[0] * contact.s[1][c] - contact.direction[1] * contact.s[0][c];
        push[c] = contact.a[c] - mu * (contact.direction[0] * contact.s[0][c] +
                                       contact.direction[1] * contact.s[1][c]);
      }
      add(push, -(contact.lambda + kPenalty * contact.b), kPenalty, contact.a);
      // Newton's step of f = limit u / |u| across u, u = f + kTrial S x: what turns the force.
      const double left = std::max(1.0 - contact.ratio, contact.ratio * kTrial / kPenalty);
      contact.stiffness = contact.ratio * kTrial / left;
      const double f = contact.direction[0] * contact.force[1] - contact.direction[1] * contact.force[0];
      contact.base = f - f / left - contact.stiffness * Dot(contact.across, x_);
      add(contact.across, contact.base, contact.stiffness, contact.across);
    }
    SolveLinear(H, x);
    std::copy(x, x + N, x_);
    for (int i = 0; i < count_; ++i) {
      Contact& contact = contact_[i];
      contact.lambda =
          contact.pressed ? contact.lambda + kPenalty * (contact.b - Dot(contact.a, x)) : 0.0;
      if (!contact.slips) {
        contact.force[0] += kPenalty * Dot(contact.s[0], x);
        contact.force[1] += kPenalty * Dot(contact.s[1], x);
      } else if (contact.pressed) {
        const double along = contact.mu() * contact.lambda;
        const double across = contact.base + contact.stiffness * Dot(contact.across, x);
        contact.force[0] = contact.direction[0] * along - contact.direction[1] * across;
        contact.force[1] = contact.direction[1] * along + contact.direction[0] * across;
      } else {
        contact.force[0] = contact.force[1] = 0.0;
      }
    }
  }

  bool Converge(StepReport& report) {
    Balance();
    for (int step = 0;; ++step) {
      double most = 0.0;
      for (int i = 0; i < count_; ++i) most = std::max(most, Judge(contact_[i]));
      if (most <= kConverged * size_) return true;
      if (step == kNewtonSteps) return false;
      ++report.friction_iterations;
      NewtonStep();
    }
  }

  /// Gives mu_d to the contacts that mu_s does not hold; false where there is none.
  bool LetSlip() {
    bool any = false;
    for (int i = 0; i < count_; ++i) {
      Contact& contact = contact_[i];
      if (!contact.slips || contact.sliding || !(contact.lambda > 0.0)) continue;
      contact.sliding = true;
      any = any || contact.mu_d != contact.mu_s;
    }
    return any;
  }

  const HapticModel& model_;
  const Mat3& R_WG_;
  const ContactRows& rows_;
  double slack_;
  bool still_;
  double t_[N], x_[N];
  double size_;  ///< of the problem: tolerances are relative to it
  int count_ = 0;
  Contact contact_[kMaxActiveRows];
};

template <int N>
void Solve(const HapticModel& model, const Kernels& kernels, const Mat3& R_WG, const double* t,
           const ContactRows& rows, FrictionState& state, QpResult& qp, FrictionForces& forces,
           StepReport& report) {
  FrictionalContacts<N> contacts(model, R_WG, rows, t, qp, state.still >= kStillCycles);
  for (int i = 0; i < qp.active; ++i) {
    const LeafPair pair = rows.pair(qp.row[i]);
    int last = 0;
    while (last < state.contacts && !(state.pair[static_cast<std::size_t>(last)] == pair)) ++last;
    const auto k = static_cast<std::size_t>(last);
    if (last < state.contacts) {
      contacts.Add(qp.row[i], state.normal_force[k], state.force[k]);
    } else {
      contacts.Add(qp.row[i], qp.multiplier[i], Vec3::Zero());
    }
  }
  bool solved = false;
  QpResult shifted;
  for (int round = 0; round < kRounds; ++round) {
    const bool converged = contacts.Solve(report);
    double target[6];
    contacts.ShiftedTarget(target);
    shifted = SolveNearestPoint<N>(kernels, target, rows.view(), qp.row, qp.active);
    report.qp_iterations += shifted.iterations;
    if (shifted.status == QpStatus::kIterationLimit) break;
    solved = converged && contacts.Agrees(shifted.x);
    if (solved) break;
    bool added = false;
    for (int i = 0; i < shifted.active; ++i) {
      added |= contacts.Add(shifted.row[i], 0.0, Vec3::Zero());
    }
    if (!added) break;
  }
  report.friction_unsolved += !solved;
  if (shifted.status == QpStatus::kIterationLimit) {
    for (Vec3& force : forces) force.setZero();
    state.contacts = 0;
    return;
  }
  if (!solved) contacts.TakeNormalForces(shifted);
  if (contacts.slips()) state.still = 0;
  std::copy(shifted.x, shifted.x + N, qp.x);
  contacts.Write(state, qp, forces);
  if constexpr (N == 6) {
    const double rho = model.rotation_length();
    const Vec3 creep = contacts.Creep(Vec3(qp.x[3], qp.x[4], qp.x[5]) / rho);
    for (int c = 0; c < 3; ++c) qp.x[c] -= creep[c];
  }
}

}  // namespace

void AddCoulombFriction(const HapticModel& model, const Kernels& kernels, const Mat3& R_WG,
                        const Target& target, const ContactRows& rows, bool first_substep,
                        FrictionState& state, QpResult& qp, FrictionForces& forces,
                        StepReport& report) noexcept {
  if (first_substep && state.still < kStillCycles) ++state.still;
  const double rho = model.rotation_length();
  const double t[6] = {target.v.x(),         target.v.y(),         target.v.z(),
                       rho * target.phi.x(), rho * target.phi.y(), rho * target.phi.z()};
  if (model.degrees_of_freedom() == 6) {
    Solve<6>(model, kernels, R_WG, t, rows, state, qp, forces, report);
  } else {
    Solve<3>(model, kernels, R_WG, t, rows, state, qp, forces, report);
  }
}

}  // namespace palpate
