#include "tests/support/support_figures.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "common/math/rotation.h"
#include "tests/support/random.h"

namespace palpate::test {
namespace {

bool TouchesLeaves(const StepReport& report) {
  const std::span contacts(report.active.data(), static_cast<std::size_t>(report.contacts));
  return report.soft_contacts > 0 ||
         std::ranges::any_of(contacts, [](const ActiveRow& row) { return row.id.IsOfLeaves(); });
}

}  // namespace

SupportMeasure::SupportMeasure(const Scene& scene, const HapticModel& model,
                               StepWorkspace& workspace)
    : scene_(scene),
      model_(model),
      workspace_(workspace),
      judge_(scene, model.reference()),
      length_(std::sqrt(scene.coupling.torsional_stiffness / scene.coupling.stiffness)) {
  figures_.not_judged_for = ContactJudge::WhyNot(scene);
}

void SupportMeasure::Count(const StepReport& report) {
  figures_.friction_unsolved += report.diagnostics.friction_unsolved > 0;
  figures_.friction_yielded += report.diagnostics.friction_yielded > 0;
}

void SupportMeasure::Judge(std::size_t step, const Pose& X_WH, const StepReport& report,
                           const StepState& state) {
  if (!figures_.not_judged_for.empty() || (report.faults & kFaultTargetFar) != 0) return;
  if (TouchesLeaves(report)) {
    ++figures_.soft;
    return;
  }
  const Wrench pull = PullAt(report.X_WG, X_WH, report.wrench);
  const ContactJudge::Verdict verdict = judge_.Judge(report.X_WG, pull, length_);
  if (figures_.force.empty() || verdict.force > std::ranges::max(figures_.force)) {
    figures_.worst_step = step;
  }
  figures_.force.push_back(verdict.force);
  figures_.torque.push_back(verdict.torque);

  // Where nothing pulls there is nothing to lose.
  const double energy = EnergyOf(pull);
  const double work =
      ContactJudge::kNear * std::hypot(pull.force.norm(), pull.torque.norm() / length_);
  const double least = std::max(SupportFigures::kFreed * energy, work);
  if (energy <= least) return;
  Random random(step + 1);
  const Quat turn = RotationExp(SupportFigures::kNudgeTurn * random.Direction());
  const Vec3 at = X_WH * model_.reference(), way = SupportFigures::kNudge * random.Direction();
  const Pose nudged{at + way - turn * (at - X_WH.p), (turn * X_WH.q).normalized()};
  ++figures_.nudged;
  if (energy - EnergyAfter(X_WH, nudged, state) <= least) return;
  if (figures_.freed++ == 0) figures_.first_freed = step;
  const bool holds = energy - EnergyAfter(X_WH, X_WH, state) <= least;
  StepState slips = state;
  slips.friction.still = 0;
  figures_.freed_unnudged += !holds;
  figures_.freed_of_stiction += holds && energy - EnergyAfter(X_WH, X_WH, slips) > least;
}

Wrench SupportMeasure::PullAt(const Pose& X_WG, const Pose& X_WH, const Wrench& published) const {
  return SpringPull(X_WG, X_WH, model_.reference(), scene_.coupling, published);
}

double SupportMeasure::EnergyOf(const Wrench& pull) const {
  return 0.5 * pull.force.squaredNorm() / scene_.coupling.stiffness +
         0.5 * pull.torque.squaredNorm() / scene_.coupling.torsional_stiffness;
}

/// The spring's energy after the hand was at `nudged` for a cycle and then held at X_WH.
double SupportMeasure::EnergyAfter(const Pose& X_WH, const Pose& nudged, StepState state) const {
  StepReport report = HapticStep(model_, nudged, state, workspace_);
  for (int i = 0; i <= SupportFigures::kHeldAfter; ++i) {
    report = HapticStep(model_, X_WH, state, workspace_);
  }
  return EnergyOf(PullAt(report.X_WG, X_WH, report.wrench));
}

}  // namespace palpate::test
