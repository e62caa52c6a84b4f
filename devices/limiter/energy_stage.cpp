#include "devices/limiter/energy_stage.h"

#include <algorithm>
#include <cmath>

#include "common/math/rotation.h"

namespace palpate {
namespace {

/// Returns false for NaN, too, since comparisons with NaN are false.  No device reaches
/// larger numbers.
bool Usable(const Pose& X) noexcept {
  return (X.p.array().abs() <= 1e3).all() && std::abs(X.q.squaredNorm() - 1.0) <= 0.01;
}

}  // namespace

double PassivityObserver::Move(const Pose& X_WH) noexcept {
  way_ = Way{};
  seen_ = Usable(X_WH);
  if (!seen_) return 0.0;  // the work is counted at the next valid pose
  const Pose now{X_WH.p, X_WH.q.normalized()};
  const Pose last = last_;
  last_ = now;
  leapt_ = !has_last_;
  has_last_ = true;
  if (leapt_) return 0.0;
  const Way way{now.p - last.p, RotationLog(now.q * last.q.conjugate())};
  leapt_ = way.p.norm() > kLeap_m || way.phi.norm() > kLeap_rad;
  if (leapt_) return 0.0;
  way_ = way;
  const double work = -(held_.force.dot(way.p) + held_.torque.dot(way.phi));
  energy_J_ += work;
  lowest_J_ = std::min(lowest_J_, energy_J_);
  return work;
}

EnergyStage::EnergyStage(const WrenchLimits& limits)
    : slew_(limits.rates().contact_force, limits.rates().contact_torque),
      scale_(limits.motion_scale()),
      position_resolution_m_(limits.position_resolution_m() / scale_),
      rotation_resolution_rad_(limits.rotation_resolution_rad()) {}

Wrench EnergyStage::Pass(const Wrench& asked, double gain, const Pose& X_WT, double dt_s, bool felt,
                         bool entering) noexcept {
  const Wrench wanted = AtTheHand(asked);
  const Pose X_WH{X_WT.p / scale_, X_WT.q};
  const double work = observer_.Move(X_WH);
  store_J_ += work;
  moved_ = moved_ || work != 0.0;
  if (observer_.leapt()) store_J_ = std::min(store_J_, 0.0);
  Settle(0.5 * gain * (wanted.force.norm() * kDeepest_m + wanted.torque.norm() * kDeepest_rad),
         dt_s);
  const double stored = 0.5 * gain * wanted.force.squaredNorm() * compliance_;
  Grant(stored, entering);
  inside_ = entering || (inside_ && !wanted.force.isZero(0.0));
  if (Rests(X_WH, dt_s) && inside_) Draw(stored - store_J_);

  tick_s_ += (dt_s - tick_s_) * (tick_s_ > 0.0 ? std::min(1.0, dt_s / kTick_s) : 1.0);

  const Way& way = observer_.way();
  const double foreseen = wanted.force.dot(way.p) + wanted.torque.dot(way.phi);
  if (dt_s > 0.0) smooth_ += (way.p / dt_s - smooth_) * std::min(1.0, dt_s / kSmooth_s);
  inwards_ = foreseen < 0.0 ? std::min(inwards_ + 1, 2) : 0;

  // A wrench whose work cannot be counted is not rendered.
  const double factor = observer_.seen() ? Factor(wanted, foreseen, gain) : 0.0;
  count_ += factor < 1.0;
  if (factor < 1.0) {
    return slew_.Pass({factor * asked.force, factor * asked.torque}, dt_s, felt);
  }
  return slew_.Pass(asked, dt_s, felt);
}

void EnergyStage::Settle(double most_J, double dt_s) noexcept {
  if (!repaid_ && observer_.energy_J() > 2.0 * kSeed_J) {
    repaid_ = true;
    store_J_ -= kReserve_J;
  }
  const double share = std::min(1.0, dt_s / kForget_s);
  if (store_J_ > most_J) {
    const double forgotten = share * (store_J_ - most_J);
    store_J_ -= forgotten;
    budget_J_ = std::min(kBudget_J, budget_J_ + forgotten);
  }
  // A debt is forgotten only as far as the hand's total input covers it.
  const double covered =
      repaid_ ? std::min(0.0, observer_.energy_J() + lent_J() - kReserve_J) : store_J_;
  if (store_J_ < covered) store_J_ += share * (covered - store_J_);
}

bool EnergyStage::Rests(const Pose& X_WH, double dt_s) noexcept {
  // Comparisons with NaN are false, so an invalid pose does not count as rest.
  const bool here =
      (X_WH.p - X_rest_.p).norm() <= 2.0 * position_resolution_m_ &&
      RotationLog(X_WH.q * X_rest_.q.conjugate()).norm() <= 2.0 * rotation_resolution_rad_;
  if (!here) X_rest_ = X_WH;
  rest_s_ = here ? rest_s_ + dt_s : 0.0;
  return rest_s_ >= kRest_s;
}

void EnergyStage::Grant(double stored_J, bool entering) noexcept {
  if (!entering) {
    entry_most_J_ = entry_granted_J_ = 0.0;
    return;
  }
  entry_most_J_ = std::max(entry_most_J_, stored_J);
  entry_granted_J_ += Draw(std::min(stored_J - store_J_, entry_most_J_ - entry_granted_J_));
}

double EnergyStage::Draw(double wanted_J) noexcept {
  if (!(wanted_J > 0.0)) return 0.0;
  const double drawn = std::min(wanted_J, budget_J_);
  budget_J_ -= drawn;
  store_J_ += drawn;
  return drawn;
}

double EnergyStage::Factor(const Wrench& wanted, double foreseen, double gain) const noexcept {
  if (!moved_ || gain == 0.0) return 1.0;
  const double force = wanted.force.norm(), torque = wanted.torque.norm();

  double factor = 1.0;
  const double store = std::max(store_J_, 0.0);
  const double stored = 0.5 * gain * force * force * compliance_;
  if (store < stored) {
    const double out = smooth_.dot(wanted.force) / force;
    const double counts = std::clamp((out - kStill_m_s) / (kMoving_m_s - kStill_m_s), 0.0, 1.0);
    factor = 1.0 - counts * (1.0 - store / stored);
  }

  // Sum over the ticks of the release: the force falls in n equal steps, and each tick's
  // displacement exceeds the previous one by `unforeseen`.
  const double accel = kHandAccel_m_s2 + force / kLeastMass_kg;
  const double unforeseen_m = accel * tick_s_ * tick_s_ + position_resolution_m_;
  const double unforeseen_rad = kMostAccel_rad_s2 * tick_s_ * tick_s_ + rotation_resolution_rad_;
  const double n = std::max({1.0, force / (slew_.force_N_s() * tick_s_ + 1e-12),
                             torque / (slew_.torque_Nm_s() / scale_ * tick_s_ + 1e-12)});
  const double more = force * unforeseen_m + torque * unforeseen_rad;
  const double spent = gain * (foreseen * (n + 1.0) / 2.0 + more * (n + 1.0) * (n + 2.0) / 6.0);

  // A hand that clearly moves in pays its debt; without a force it could not.
  const bool inwards = inwards_ > 1 || smooth_.dot(wanted.force) < -kInwards_m_s * force;
  const double budget = inwards ? store + kSeed_J : std::max(0.0, store_J_ + kSeed_J);
  return spent > budget ? std::min(factor, budget / spent) : factor;
}

}  // namespace palpate
