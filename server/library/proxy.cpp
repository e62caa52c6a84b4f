#include "server/library/proxy.h"

#include <utility>

#include "common/error.h"
#include "common/math/pose_check.h"
#include "server/physics/start_pose.h"

namespace palpate {

Proxy::Proxy(const HapticModel& model, const Pose& X_WH)
    : model_(model), workspace_(model), state_(model) {
  Restart(X_WH);
}

void Proxy::Restart(const Pose& hand) {
  if (!IsPose(hand)) throw Error("hand: its pose must be finite, its quaternion of length 1");
  const Pose X_WH = Unit(hand);
  const StartPose start = ResolveStart(model_, X_WH, workspace_, state_.cut.fields);
  StepState fresh(model_);  // fresh, as for a new session
  fresh.cut.fields = std::move(state_.cut.fields);
  state_ = std::move(fresh);
  state_.X_WG = start.X_WG;
  start_depth_ = start.depth;
}

}  // namespace palpate
