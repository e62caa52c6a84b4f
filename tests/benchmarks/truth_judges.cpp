#include "tests/benchmarks/truth_judges.h"

#include <algorithm>

#include "common/math/rotation.h"

namespace palpate::bench {
namespace {

bool Late(const StepReport& report) {
  return (report.faults & kFaultTargetFar) != 0;
}

/// Keeps the greater, or what is no number.
void Worst(double& worst, double value) {
  if (!(value <= worst)) worst = value;
}

}  // namespace

void SmoothJudge::See(std::size_t i, const StepReport& report) {
  const Vec3& force = report.wrench.force;
  const Vec3& axis = truth_.axis.size() == 1 ? truth_.axis.front() : truth_.axis[i];
  const double along = force.dot(axis);
  Worst(sideways_, truth_.across ? std::abs(along) : (force - along * axis).norm());
  ++cycles_;
  late_ += Late(report);
  faults_ += (report.faults & ~kFaultTargetFar) != 0;
  if (truth_.force.empty()) return;
  const double off = (force - truth_.force[i]).norm();
  Worst(off_, off);
  if (!Late(report)) Worst(arrived_off_, off);
  Worst(torque_, report.wrench.torque.norm());
}

void SmoothJudge::Tell(Tally& tally) const {
  constexpr double kFelt = 0.01;  // [N]
  tally.Count("slides", 1);
  tally.Count("over 0.01 N", !(sideways_ <= kFelt));
  tally.Most("sideways N", sideways_);
  tally.Count("cycles", cycles_);
  tally.Count("late", late_);
  tally.Count("faults", faults_);
  tally.Most("force off N", off_);
  tally.Most("arrived off N", arrived_off_);
  tally.Most("torque N m", torque_);
}

void SteadyJudge::See(std::size_t i, const StepReport& report) {
  touching_ += report.contacts > 0;
  late_ += Late(report);
  unsolved_ += report.diagnostics.friction_unsolved > 0;
  yielded_ += report.diagnostics.friction_yielded > 0;
  const Vec3& force = report.wrench.force;
  if (i >= slide_.steady) SeeSteady(i, force, RotationLog(report.X_WG.q * q_.conjugate()));
  force_ = force;
  q_ = report.X_WG.q;
}

void SteadyJudge::SeeSteady(std::size_t i, const Vec3& force, const Vec3& turn) {
  constexpr double kTurning = 1e-3;
  const Vec3& n = slide_.normal;
  const double load = force.dot(n), way = 1e-3 * slide_.speed;
  const Vec3 rub = force - load * n;
  const double mu = load > 0.0 ? rub.norm() / load : 0.0;
  // What the hand itself changes is none of friction's.
  const double by_hand = slide_.stiffness * std::hypot(1.0, kTruthDynamic) *
                         std::abs(slide_.depth[i] - slide_.depth[i - 1]);
  Worst(change_, std::max(0.0, ((force - force_).norm() - by_hand) / std::max(load, 1e-3)));
  if (std::abs(turn.dot(n)) * slide_.reach > kTurning * way) {
    ++turning_;
    return;
  }
  ++judged_;
  least_ = std::min(least_, mu);
  Worst(most_, mu);
  if (mu < 0.1 * kTruthDynamic) return;  // a direction of hardly anything
  const double off = std::atan2(rub.cross(slide_.along).norm(), -rub.dot(slide_.along));
  Worst(direction_, std::max(0.0, off - std::atan(turn.norm() * slide_.reach / way)));
}

void SteadyJudge::Tell(Tally& tally) const {
  constexpr double kOff = 0.01 * kTruthDynamic;
  tally.Count("slides", 1);
  tally.Count("1 % off", least_ < kTruthDynamic - kOff || !(most_ <= kTruthDynamic + kOff));
  tally.Least("mu least", least_);
  tally.Most("mu most", most_);
  tally.Most("direction deg", 180.0 / M_PI * direction_);
  tally.Most("change N/N", change_);
  tally.Count("touching", touching_);
  tally.Count("unsolved", unsolved_);
  tally.Count("yielded", yielded_);
  tally.Count("late", late_);
  tally.Count("judged", judged_);
  tally.Count("turning", turning_);
}

}  // namespace palpate::bench
