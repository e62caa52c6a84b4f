#include <algorithm>
#include <limits>
#include <span>

#include "common/math/rotation.h"
#include "server/physics/limits.h"
#include "server/physics/solve/stages.h"

namespace palpate {
namespace {

/// Returns the distance of p from the screw axis of the movement that rotates the tool by `turn`
/// while its reference point moves from `from` by `advance`.
double DistanceFromAxis(const Vec3& p, const Quat& turn, const Vec3& from, const Vec3& advance) {
  const double sine = turn.vec().norm();  // of half the angle
  const Vec3 axis = turn.vec() / sine;
  const Vec3 across = advance - advance.dot(axis) * axis;
  const Vec3 on_axis = from + 0.5 * (across + turn.w() / sine * axis.cross(across));
  return (p - on_axis).cross(axis).norm();
}

}  // namespace

void AddChapterFriction(const HapticModel& model, const Pose& X_before, StepState& state,
                        StepReport& report) noexcept {
  const std::span contacts(report.active.data(), static_cast<std::size_t>(report.contacts));
  const Pose X_WG = state.X_WG;
  Vec3 point = Vec3::Zero();  // 2.26: like mu_s and mu_d, a mean over the contacts
  double mu_s = 0.0, mu_d = 0.0, pressed = 0.0;
  for (const ActiveRow& row : contacts) {
    point += row.contact_W / report.contacts;
    mu_s += row.material->static_friction / report.contacts;
    mu_d += row.material->dynamic_friction / report.contacts;
    pressed += row.force;
  }
  if (contacts.empty() || !(mu_s > 0.0) || !(pressed > 0.0)) {
    state.friction.resets = 0;
    return;
  }
  const Pose X_WG_inverse = X_WG.Inverse();
  const Vec3 point_G = X_WG_inverse * point;
  const double depth = (point - state.X_WH * point_G).norm();  // 2.25, 2.27
  const double moved = (X_before * point_G - point).norm();
  const double k_alpha = moved <= mu_s * depth ? 1.0 : mu_d / mu_s;  // 2.30

  const Vec3& reference = model.reference();
  const Vec3 p_before = X_before * reference, p_now = X_WG * reference;
  const Quat turn = X_WG.q * X_before.q.conjugate();
  const Vec3 angle = RotationLog(turn);
  double k_theta = 1.0;
  const bool turns =
      !model.is_ball() && turn.vec().squaredNorm() > limits::friction::kLeastRotation;
  if (turns) {
    double arm = std::numeric_limits<double>::infinity();
    for (const ActiveRow& row : contacts) {
      arm = std::min(arm, DistanceFromAxis(row.contact_W, turn, p_before, p_now - p_before));
    }
    if (arm * angle.norm() > mu_s * depth) k_theta = mu_d / mu_s;  // 2.32
  }

  const Vec3 p_star = p_before + (1.0 - k_alpha) * (p_now - p_before);    // 2.29
  const Quat q_star = RotationExp((1.0 - k_theta) * angle) * X_before.q;  // 2.33
  const StepParameters& parameters = model.parameters();
  const Vec3 force = parameters.stiffness * (p_star - state.X_WH * reference);  // 2.28
  const Vec3 added = force - report.wrench.force;
  report.wrench.force = force;
  if (!model.is_ball()) {
    Vec3 went = -(X_WG.q * state.rotation_G);
    report.wrench.torque = parameters.torsional_stiffness *
                           RotationLogFrom(q_star * state.X_WH.q.conjugate(), went);  // 2.31
  }
  const bool reset = k_alpha == 1.0 && k_theta == 1.0;  // 2.34
  for (ActiveRow& row : contacts) {
    row.friction = row.force / pressed * added;
    if (!reset) continue;
    row.offset += row.normal.dot(p_now - p_before) + row.lever_cross_normal.dot(angle);
    row.contact_W = X_before * (X_WG_inverse * row.contact_W);
  }
  state.friction.resets = reset ? state.friction.resets + 1 : 0;
  report.diagnostics.friction_resets = state.friction.resets;
  if (reset) state.X_WG = X_before;
}

}  // namespace palpate
