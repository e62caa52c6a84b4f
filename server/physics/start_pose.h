#pragma once

#include <span>

#include "common/math/pose.h"
#include "scenes/grid/cut_field.h"
#include "server/physics/haptic_step.h"

namespace palpate {

/// The pose at which the graphic tool may start for a haptic pose: X_WH itself if that is free,
/// else a free pose near it.
/// @field depth  distance from X_WH to X_WG [m]; 0 if X_WH is free, infinite if it is not finite.
struct StartPose {
  Pose X_WG;
  double depth = 0.0;
};

/// Finds a start pose for a tool that may penetrate an object.  Not real-time (milliseconds);
/// called before forces begin.
/// `cuts`: what has been removed from the solids, as in StepState; empty means nothing.
StartPose ResolveStart(const HapticModel& model, const Pose& X_WH, StepWorkspace& workspace,
                       std::span<const CutField> cuts = {});

}  // namespace palpate
