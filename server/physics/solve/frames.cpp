#include <algorithm>

#include "common/math/pose_check.h"
#include "common/math/rotation.h"
#include "server/physics/solve/stages.h"

namespace palpate {
namespace {

Pose Between(const Pose& from, const Pose& to, double fraction) {
  if (fraction == 1.0) return to;
  const Vec3 turn = RotationLog(to.q * from.q.conjugate());
  return {from.p + fraction * (to.p - from.p),
          (RotationExp(fraction * turn) * from.q).normalized()};
}

/// Calls visit(contact, frame) for each frame that can move, other tools apart.
template <class Visit>
void ForEachMoving(StepContext& context, Visit visit) {
  if (!context.buffers().meshes) return;
  std::vector<MeshContact>& of = context.buffers().meshes->of;
  for (std::size_t i = 1; i < of.size(); ++i) {
    if (context.ToolOf(of[i]) < 0) visit(of[i], context.FrameOf(of[i]));
  }
}

FrameMotion MotionTo(const StepContext& context, const BodyFrame& frame, const Pose& to) {
  return FrameMotion(frame.X_WB, to, context.tools.p_G, !context.model.is_ball());
}

}  // namespace

void AimFrames(const HapticModel& model, StepState& state) noexcept {
  const std::span groups = model.moved();
  if (groups.empty() || state.moved < 0) return;
  ++state.moved;
  for (std::size_t i = 0; i < groups.size(); ++i) {
    if (!groups[i].free) state.frames[i + 1].X_WB_next = groups[i].At(state.moved);
  }
}

StepBounds MotionOfFrames(StepContext& context) noexcept {
  StepBounds most{0.0, 0.0};
  ForEachMoving(context, [&](const MeshContact&, BodyFrame& frame) {
    if (!IsPose(frame.X_WB_next)) {
      frame.X_WB_next = frame.X_WB;
      context.report().faults |= kFaultBadPose;
    }
    const FrameMotion motion = MotionTo(context, frame, frame.X_WB_next);
    most.translation = std::max(most.translation, motion.own_v().norm());
    most.rotation = std::max(most.rotation, motion.own_phi().norm());
  });
  return most;
}

void BeginFrames(Party tools, bool move) noexcept {
  double part = 1.0;
  for (StepContext* tool : tools) {
    const StepBounds left = MotionOfFrames(*tool), bounds = tool->sub_step.bounds;
    part = std::min({part, bounds.translation / std::max(left.translation, bounds.translation),
                     bounds.rotation / std::max(left.rotation, bounds.rotation)});
  }
  for (StepContext* tool : tools) {
    tool->sub_step.of_frames = part;
    PlaceFrames(*tool, move ? 1.0 : 0.0);
  }
}

void PlaceTools(Party tools) noexcept {
  if (tools.size() == 1) return;
  for (StepContext* tool : tools) {
    for (MeshContact& contact : tool->buffers().meshes->of) {
      const std::int32_t number = tool->ToolOf(contact);
      if (number < 0) continue;
      const StepContext& other = *tools[static_cast<std::size_t>(number)];
      const Advance &step = tool->advance, &others = other.advance;
      const auto pose = [&](const Vec3& p, const Quat& q) {
        return Pose{p - q * other.model.reference(), q};
      };
      const Vec3 p_end = other.tools.p_G + others.v;
      const Quat q_end = (RotationExp(others.phi) * other.tools.q_G).normalized();
      Pose& X_WB = tool->FrameOf(contact).X_WB;
      X_WB = pose(other.tools.p_G, other.tools.q_G);
      contact.moved = FrameMotion(X_WB, pose(p_end, q_end), tool->tools.p_G, !tool->model.is_ball(),
                                  {number, others.v, others.phi, tool->tools.p_G + step.v - p_end});
    }
  }
}

void PlaceFrames(StepContext& context, double fraction) noexcept {
  ForEachMoving(context, [&](MeshContact& contact, const BodyFrame& frame) {
    const double part = fraction * context.sub_step.of_frames;
    contact.moved = MotionTo(context, frame, Between(frame.X_WB, frame.X_WB_next, part));
  });
}

bool MoveFrames(StepContext& context) noexcept {
  const double part = context.advance.of_frames * context.sub_step.of_frames;
  bool moved = false;
  ForEachMoving(context, [&](const MeshContact& contact, BodyFrame& frame) {
    moved |= contact.moved.moves();
    frame.X_WB = Between(frame.X_WB, frame.X_WB_next, part);
  });
  return !moved || part == 1.0;
}

}  // namespace palpate
