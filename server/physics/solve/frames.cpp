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

/// Calls visit(contact, frame) for each frame that can move.
template <class Visit>
void ForEachMoving(StepContext& context, Visit visit) {
  if (!context.buffers().meshes) return;
  std::vector<MeshContact>& of = context.buffers().meshes->of;
  for (std::size_t i = 1; i < of.size(); ++i) visit(of[i], context.FrameOf(of[i]));
}

FrameMotion MotionTo(const StepContext& context, const BodyFrame& frame, const Pose& to) {
  return FrameMotion(frame.X_WB, to, context.tools.p_G, !context.model.is_ball());
}

}  // namespace

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

void BeginFrames(StepContext& context, bool move) noexcept {
  const StepBounds left = MotionOfFrames(context), bounds = context.sub_step.bounds;
  context.sub_step.of_frames =
      std::min(bounds.translation / std::max(left.translation, bounds.translation),
               bounds.rotation / std::max(left.rotation, bounds.rotation));
  PlaceFrames(context, move ? 1.0 : 0.0);
}

void PlaceFrames(StepContext& context, double fraction) noexcept {
  ForEachMoving(context, [&](MeshContact& contact, const BodyFrame& frame) {
    const double part = fraction * context.sub_step.of_frames;
    contact.moved = MotionTo(context, frame, Between(frame.X_WB, frame.X_WB_next, part));
  });
}

bool MoveFrames(StepContext& context, const Advance& advance) noexcept {
  const double part = advance.of_frames * context.sub_step.of_frames;
  bool moved = false;
  ForEachMoving(context, [&](const MeshContact& contact, BodyFrame& frame) {
    moved |= contact.moved.moves();
    frame.X_WB = Between(frame.X_WB, frame.X_WB_next, part);
  });
  return !moved || part == 1.0;
}

}  // namespace palpate
