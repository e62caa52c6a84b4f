#include "client/station/local_contact_model.h"

#include <algorithm>
#include <cmath>

#include "common/math/rotation.h"
#include "common/qp/nearest_point.h"
#include "common/step_fault.h"

namespace palpate {
namespace {

/// The server's normals have unit length up to rounding.
constexpr double kUnitTolerance = 1e-6;
/// No tool is longer [m].
constexpr double kMostLever_m = 100.0;
/// The graphic tool satisfies its rows up to rounding; a jam leaves them violated by micrometres.
constexpr double kMostViolation_m = 1e-4;
/// Largest ratio of a wrench's unexplained part to the normal force.  That part is friction; a
/// larger one is not, and would have to drop too steeply where contact ends.
constexpr double kMostUnexplained = 2.0;
constexpr double kRounding_N = 1e-6;
/// A difference below this is zero [N, N m]: less than any motor renders.
constexpr double kGone = 1e-6;

bool IsFinite(const Wrench& wrench) noexcept {
  return wrench.force.allFinite() && wrench.torque.allFinite();
}

/// Returns 1 up to `reach`, 0 from twice as far, with a smooth transition.
double Fade(double distance, double reach) noexcept {
  if (distance <= reach) return 1.0;
  if (!(distance < 2.0 * reach)) return 0.0;
  const double x = 2.0 - distance / reach;
  return x * x * (3.0 - 2.0 * x);
}

Wrench Scaled(double factor, const Wrench& wrench) noexcept {
  return {factor * wrench.force, factor * wrench.torque};
}

}  // namespace

void LocalContactModel::SetSpring(const CouplingSpring& spring) noexcept {
  spring_ = spring;
  rho_ = spring.stiffness > 0.0 ? std::sqrt(spring.torsional_stiffness / spring.stiffness) : 1.0;
}

bool LocalContactModel::Usable(const Reply& reply) const noexcept {
  const LocalRows& local = reply.local;
  if (!(spring_.stiffness > 0.0) || !(rho_ > 0.0) || !std::isfinite(rho_)) return false;
  if (local.count < 1 || local.count > LocalRows::kMost) return false;
  if (!IsFinite(reply.wrench) || !reply.X_WG.p.allFinite() ||
      !(std::abs(reply.X_WG.q.squaredNorm() - 1.0) <= kUnitTolerance)) {
    return false;
  }
  // Comparisons with NaN are false.
  if (!(local.region_m > 0.0) || !(local.region_rad > 0.0) || !(local.valid_s > 0.0)) return false;
  return std::all_of(local.row.begin(), local.row.begin() + local.count, [](const LocalRow& row) {
    return std::abs(row.normal.squaredNorm() - 1.0) <= kUnitTolerance &&
           row.lever_cross_normal.squaredNorm() <= kMostLever_m * kMostLever_m &&
           std::isfinite(row.offset) && row.offset <= kMostViolation_m;
  });
}

void LocalContactModel::Remember(Contact& contact) noexcept {
  const Pose& X_WG = contact.reply.X_WG;
  const Vec3 v = X_WG * spring_.reference - touched_.X_WG * spring_.reference;
  const Vec3 phi = RotationLog(X_WG.q * touched_.X_WG.q.conjugate());
  LocalRows kept = touched_.local;
  for (int i = 0; i < kept.count; ++i) {
    LocalRow& row = kept.row[static_cast<std::size_t>(i)];
    row.offset -= row.normal.dot(v) + row.lever_cross_normal.dot(phi);
    // The server's tool is where this row forbids it: the contact has ended.
    has_touched_ = has_touched_ && row.offset <= kMostViolation_m;
  }
  if (!has_touched_) return;
  contact.reply.local = kept;
  contact.v = -v;
  contact.phi = -phi;
}

/// @param turn  the spring's former rotation vector, which extends it past half a turn.
LocalContactModel::Step LocalContactModel::Solve(const Reply& reply, const Pose& X_WH,
                                                 const Vec3& turn) const noexcept {
  Step step;
  step.turn = turn;
  const Vec3 v_h = X_WH * spring_.reference - reply.X_WG * spring_.reference;
  const Vec3 phi_h = RotationLogFrom(X_WH.q * reply.X_WG.q.conjugate(), step.turn);
  const double target[6] = {v_h.x(),          v_h.y(),          v_h.z(),
                            rho_ * phi_h.x(), rho_ * phi_h.y(), rho_ * phi_h.z()};
  constexpr int kPadded = 16;
  alignas(64) double column[7][kPadded] = {};
  QpRows rows{};
  for (int c = 0; c < 6; ++c) rows.a[c] = column[c];
  rows.b = column[6];
  rows.count = reply.local.count;
  for (int i = 0; i < kPadded; ++i) {
    if (i >= rows.count) {
      column[6][i] = -1e300;
      continue;
    }
    const LocalRow& row = reply.local.row[static_cast<std::size_t>(i)];
    for (int k = 0; k < 3; ++k) {
      column[k][i] = row.normal[k];
      column[3 + k][i] = row.lever_cross_normal[k] / rho_;
    }
    column[6][i] = row.offset;
  }
  const QpResult qp = SolveNearestPoint(target, rows, nullptr, 0);

  const double* x = qp.x;
  step.v = Vec3(x[0], x[1], x[2]);
  step.phi = Vec3(x[3], x[4], x[5]) / rho_;
  if (qp.active == 0) return step;
  step.wrench.force = spring_.stiffness * (step.v - v_h);
  step.wrench.torque = spring_.torsional_stiffness * RotationDifference(step.phi, phi_h);
  double squares = 0.0;
  for (int c = 0; c < 6; ++c) squares += (x[c] - target[c]) * (x[c] - target[c]);
  step.stretch = std::sqrt(squares);
  return step;
}

void LocalContactModel::Take(const Reply& reply, const Pose& X_WH) noexcept {
  next_ = Contact{};
  next_.reply = reply;
  next_.remainder = reply.wrench;
  has_next_ = true;
  const bool free = reply.local.count == 0 && reply.wrench.force.isZero(0.0) &&
                    reply.wrench.torque.isZero(0.0) && reply.faults == kFaultNone;
  if (reply.faults & kFaultNotStarted) Forget();  // of a former session
  const bool remembers = has_touched_ && free;
  if (remembers) Remember(next_);
  if (!Usable(next_.reply)) return;
  // The server's torque determines the side of half a turn on which its spring is.
  next_.answered =
      Solve(next_.reply, X_WH, -next_.reply.wrench.torque / spring_.torsional_stiffness);
  if (!remembers) {
    next_.v = next_.answered.v;
    next_.phi = next_.answered.phi;
  }
  const Wrench remainder = Sum(reply.wrench, Scaled(-1.0, next_.answered.wrench));
  const double size = std::hypot(remainder.force.norm(), remainder.torque.norm() / rho_);
  next_.has_rows =
      size <= kMostUnexplained * spring_.stiffness * next_.answered.stretch + kRounding_N;
  if (!next_.has_rows) return;
  next_.remainder = remainder;
  if (!free) {
    touched_ = reply;
    has_touched_ = true;
  }
}

LocalContactModel::Evaluation LocalContactModel::Evaluate(const Contact& contact,
                                                          std::int64_t now_ns,
                                                          const Pose& X_WH) const noexcept {
  Evaluation out;
  if (!contact.has_rows) {
    out.wrench = contact.remainder;
    return out;
  }
  const Reply& reply = contact.reply;
  const Step step = Solve(reply, X_WH, contact.answered.turn);
  const double age_s = 1e-9 * static_cast<double>(now_ns - reply.pose_time_ns);
  const double believed = Fade((step.v - contact.v).norm(), reply.local.region_m) *
                          Fade((step.phi - contact.phi).norm(), reply.local.region_rad) *
                          Fade(age_s, reply.local.valid_s);
  const double kept =
      step.stretch >= contact.answered.stretch ? 1.0 : step.stretch / contact.answered.stretch;
  out.wrench = Scaled(believed, Sum(step.wrench, Scaled(kept, contact.remainder)));
  out.evaluated = true;
  out.beyond_region = believed < 1.0 && step.stretch > 0.0;
  return out;
}

LocalContactModel::Evaluation LocalContactModel::At(std::int64_t now_ns,
                                                    const Pose& X_WH) noexcept {
  const double dt_s = 1e-9 * static_cast<double>(now_ns - last_ns_);
  last_ns_ = now_ns;
  if (has_next_) {
    const Wrench before = Sum(Evaluate(contact_, now_ns, X_WH).wrench, blend_);
    contact_ = next_;
    has_next_ = false;
    const Wrench after = Evaluate(contact_, now_ns, X_WH).wrench;
    blend_ = Sum(before, Scaled(-1.0, after));
    if (!enabled_ || !IsFinite(blend_)) blend_ = Wrench{};
  }
  // An implicit Euler step, not libm's exp: the same bits on every processor.
  blend_ = Scaled(kBlend_s / (kBlend_s + std::max(dt_s, 0.0)), blend_);
  if (blend_.force.norm() < kGone && blend_.torque.norm() < kGone) blend_ = Wrench{};
  if (!enabled_) return {contact_.reply.wrench};
  Evaluation now = Evaluate(contact_, now_ns, X_WH);
  now.wrench = Sum(now.wrench, blend_);
  return now;
}

}  // namespace palpate
