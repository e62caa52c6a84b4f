#pragma once

#include <span>

#include "common/math/pose.h"
#include "scenes/grid/cut_field.h"
#include "server/physics/haptic_step.h"

namespace palpate {

/// Where the graphic tool may start for a haptic pose: at X_WH itself if that is free, else at a
/// free pose near it.
/// @field depth  distance from X_WH to X_WG [m]; 0 where X_WH is free.
struct StartPose {
  Pose X_WG;
  double depth = 0.0;
};

/// Resolves a start in penetration.  Not real-time (milliseconds): called before forces begin.
/// `cuts`: what is gone of the solids, as in a StepState; empty: nothing is.
StartPose ResolveStart(const HapticModel& model, const Pose& X_WH, StepWorkspace& workspace,
                       std::span<const CutField> cuts = {});

}  // namespace palpate
