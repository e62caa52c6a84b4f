#include "tests/support/jump_cause.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "common/math/rotation.h"

namespace palpate::test {
namespace {

double FrictionOf(const StepReport& report) {
  double sum = 0.0;
  for (int i = 0; i < report.contacts; ++i) {
    sum += report.active[static_cast<std::size_t>(i)].friction.norm();
  }
  return sum;
}

}  // namespace

const char* NameOf(JumpCause cause) {
  switch (cause) {
    case JumpCause::kNone:
      return "none";
    case JumpCause::kHand:
      return "hand";
    case JumpCause::kLedge:
      return "ledge";
    case JumpCause::kGained:
      return "contact_gained";
    case JumpCause::kLost:
      return "contact_lost";
    case JumpCause::kLetGo:
      return "friction_let_go";
    case JumpCause::kUnexplained:
      break;
  }
  return "unexplained";
}

JumpJudge::JumpJudge(const Scene& scene, const HapticModel& model)
    : centroid_(model.reference()),
      stiffness_(model.parameters().stiffness),
      // No contact rotates a ball, and rotating the hand does not move it.
      rotation_length_(model.is_ball() ? 0.0 : model.rotation_length()),
      radius_(model.is_ball() ? model.tool().leaves.front().radius : 0.0) {
  Vec3 low = Vec3::Constant(INFINITY), high = -low;
  for (const Vec3& v : scene.tools.front().mesh.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  reach_ = kSameShare * (high - low).maxCoeff();
}

double JumpJudge::Motion(const Pose& from, const Pose& to) const {
  const double v = (to * centroid_ - from * centroid_).norm();
  return std::hypot(v, rotation_length_ * RotationLog(to.q * from.q.conjugate()).norm());
}

double JumpJudge::Stretch(const Wrench& wrench) const {
  const double turn = rotation_length_ > 0.0 ? wrench.torque.norm() / rotation_length_ : 0.0;
  return std::hypot(wrench.force.norm(), turn) / stiffness_;
}

double JumpJudge::SpringFactor(double stretch) const {
  // A ball pressed deeper than its radius does not roll round an edge, but leaves it at a ledge.
  if (!(stretch < radius_)) return kSpringFactor;
  return std::max(kSpringFactor, radius_ / (radius_ - stretch));
}

bool JumpJudge::Has(const StepReport& report, const ActiveRow& contact) const {
  for (int i = 0; i < report.contacts; ++i) {
    const ActiveRow& other = report.active[static_cast<std::size_t>(i)];
    if (other.id == contact.id) return true;
    if ((other.contact_W - contact.contact_W).norm() <= reach_ &&
        other.normal.dot(contact.normal) >= kSameCosine) {
      return true;
    }
  }
  return false;
}

double JumpJudge::ByHand(const Pose& X_WH_before, const StepReport& before, const Pose& X_WH,
                         const StepReport& after) const {
  const double deepest = std::max(Stretch(before.wrench), Stretch(after.wrench));
  return SpringFactor(deepest) * stiffness_ * Motion(X_WH_before, X_WH);
}

JumpCause JumpJudge::Judge(const Pose& X_WH_before, const StepReport& before, const Pose& X_WH,
                           const StepReport& after) const {
  const double jump = (after.wrench.force - before.wrench.force).norm();
  if (!(jump > kJump)) return std::isfinite(jump) ? JumpCause::kNone : JumpCause::kUnexplained;
  const double hand = Motion(X_WH_before, X_WH);
  if (jump <= ByHand(X_WH_before, before, X_WH, after)) return JumpCause::kHand;

  bool gained = false, lost = false;
  for (int i = 0; i < after.contacts; ++i) {
    gained |= !Has(before, after.active[static_cast<std::size_t>(i)]);
  }
  for (int i = 0; i < before.contacts; ++i) {
    lost |= !Has(after, before.active[static_cast<std::size_t>(i)]);
  }
  const bool had_arrived = (before.faults & kFaultTargetFar) == 0;
  const double stretched = Stretch(after.wrench) - Stretch(before.wrench);
  if (had_arrived && stretched > kSpringFactor * hand) return JumpCause::kUnexplained;
  const bool snapped = Motion(before.X_WG, after.X_WG) > kSnapFactor * hand;
  if (gained || lost) {
    return snapped ? JumpCause::kLedge : gained ? JumpCause::kGained : JumpCause::kLost;
  }
  if (FrictionOf(before) - FrictionOf(after) >= 0.5 * jump) return JumpCause::kLetGo;
  const bool relaxed = Stretch(after.wrench) < Motion(before.X_WG, X_WH);
  return snapped && had_arrived && relaxed ? JumpCause::kLedge : JumpCause::kUnexplained;
}

}  // namespace palpate::test
