#include "server/physics/start_pose.h"

#include <algorithm>
#include <utility>

#include "common/math/default_rounding.h"
#include "common/math/pose_check.h"
#include "server/physics/contact/sub_step.h"
#include "server/physics/limits.h"
#include "server/physics/solve/step_context.h"
#include "server/physics/tree/sphere_tree_query.h"

namespace palpate {
namespace {

/// How deep, over the grid's spacing, a bur in its own cut may be in the solid: the cut's surface
/// lies within the true one by the error of the bur's chords (CutField).
constexpr double kOwnCut = 1.0 / 16.0;

/// Returns whether a bur is inside what is left of a solid; for any other tool, whether its mesh,
/// if it intersects none, lies inside.
bool IsInSolid(const HapticModel& model, const RelativePose& at, std::span<const CutField> cuts) {
  for (std::size_t i = 0; i < model.solids().size(); ++i) {
    const CutSolid& solid = model.solids()[i];
    const Pose X_BW = solid.X_WB.Inverse();
    const double least = -kOwnCut * solid.grid->field().lattice().spacing;
    const auto is_in = [&](const Vec3& point) {
      const Vec3 p_B = X_BW * (at.p + at.R * point);
      return (cuts.empty() ? solid.grid->Sample(p_B) : cuts[i].Sample(p_B)).distance < least;
    };
    if (model.cutting() == nullptr && is_in(model.tool_body()->mesh.vertices()[0])) return true;
    if (std::ranges::any_of(model.bur_samples(), is_in, &BurSample::point)) return true;
  }
  return false;
}

bool IsFree(const HapticModel& model, const Pose& X_WT, std::span<const CutField> cuts,
            StepWorkspace& workspace) {
  StepBuffers& buffers = workspace.buffers();
  const RelativePose at(X_WT * model.reference(), X_WT.q);
  if (buffers.prediction.Overlaps(model, ActiveKernels(), at.R, at.p)) return false;
  if (IsInSolid(model, at, cuts)) return false;
  if (!buffers.meshes) return true;
  // A tool whose mesh intersects no other lies wholly inside an object or wholly outside.
  const auto is_free = [&](MeshContact& contact) {
    const auto is_hand = [&](const ContactBody& body) {
      return body.frame == contact.meshes.frame && body.tool >= 0 && !body.is_body;
    };
    return std::ranges::any_of(model.bodies(), is_hand) || IsFree(contact.meshes, at);
  };
  return buffers.meshes->All(is_free) &&
         !Hold(model.bodies(), at.p + at.R * model.tool_body()->mesh.vertices()[0]);
}

/// Returns the distance between two tried places on the path out [m].
double StrideOf(const HapticModel& model) {
  double stride = limits::kStartStride * model.parameters().widest_step;
  for (const CutSolid& solid : model.solids()) {
    stride = std::min<double>(stride, solid.grid->field().band());
  }
  return stride;
}

/// Finds the direction and the length of the shortest of 26 paths out, along the directions of a
/// cube's faces, edges and corners, to within a stride: moves outward along all of them together
/// until one is free, which ends because every object does.
std::pair<Vec3, double> FindExit(const HapticModel& model, const Pose& X_WH,
                                 std::span<const CutField> cuts, StepWorkspace& workspace) {
  const double stride = StrideOf(model);
  for (double s = stride;; s += stride) {
    for (int i = 0; i < 27; ++i) {
      if (i == 13) continue;  // the middle
      const Vec3 d = Vec3(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1).normalized();
      Pose X = X_WH;
      X.p += s * d;
      if (IsFree(model, X, cuts, workspace)) return {d, s};
    }
  }
}

}  // namespace

bool Meet(const HapticModel& model, const Pose& X_WT, std::int32_t tool, const Pose& X_WB,
          StepWorkspace& workspace) noexcept {
  const auto body = std::ranges::find(model.bodies(), tool, &ContactBody::tool);
  const Pose X_BT = X_WB.Inverse() * X_WT;
  const RelativePose at(X_BT * model.reference(),
                        model.is_ball() ? Quat::Identity() : X_BT.q.normalized());
  const auto& frames = workspace.buffers().meshes->of;
  if (!IsFree(frames[static_cast<std::size_t>(body->frame)].meshes, at)) return true;
  const MovingBody& own = *model.tool_body();
  return Holds(*body->shape, body->X_BS.Inverse() * (at.p + at.R * own.mesh.vertices()[0])) ||
         (!model.is_ball() &&
          Holds(own, at.R.transpose() * (body->X_BS * body->shape->mesh.vertices()[0] - at.p)));
}

StartPose ResolveStart(const HapticModel& model, const Pose& X_WH, StepWorkspace& workspace,
                       std::span<const CutField> cuts) {
  const DefaultRounding rounding;
  StepState state;
  state.moved = -1;  // groups are where they begin
  if (!model.boxes().empty() && model.tool_body() != nullptr) {
    state.solids = SolidBodies(model.uncut());
    state.MakeFrames(model.bodies());
    if (!cuts.empty()) state.solids.Begin(cuts, state.frames.front().front);
    for (MeshContact& contact : workspace.buffers().meshes->of) {
      contact.meshes.solids = &state.solids;
      contact.meshes.cuts = true;
    }
  }
  Pose X_start{X_WH.p, X_WH.q.normalized()};
  if (!IsPose(X_start)) return {X_start, kInfinity};
  if (IsFree(model, X_start, cuts, workspace)) return {X_start, 0.0};

  auto [outward, shortest] = FindExit(model, X_start, cuts, workspace);
  // Then the tool goes back as near as contact allows: the step itself walks there and cannot enter
  // an object.  A bur could enter, so it instead returns by halving the last stride.
  if (model.cuts()) {
    double near = shortest - StrideOf(model);
    while (shortest - near > limits::kSettled) {
      const double middle = 0.5 * (near + shortest);
      Pose X = X_start;
      X.p += middle * outward;
      (IsFree(model, X, cuts, workspace) ? shortest : near) = middle;
    }
  }
  if (!model.solids().empty() && !model.cuts()) {
    state.cut.fields = StepState(model).cut.fields;
    std::ranges::copy(cuts, state.cut.fields.begin());
  }
  state.friction.suspended = true;
  state.X_WG = X_start;
  state.X_WG.p += shortest * outward;
  for (int i = 0; !model.cuts() && i < limits::kLongestWalk; ++i) {
    const Vec3 before = state.X_WG.p;
    const StepReport report = HapticStep(model, X_start, state, workspace);
    if ((report.faults & kFaultTargetFar) == 0 &&
        (report.X_WG.p - before).norm() < limits::kSettled)
      break;
  }
  const Vec3& c = model.reference();
  return {state.X_WG, (state.X_WG * c - X_start * c).norm()};
}

}  // namespace palpate
