#pragma once

#include <span>

#include "common/math/pose.h"
#include "scenes/grid/cut_field.h"
#include "server/physics/haptic_step.h"
#include "server/physics/tree/leaf_wear.h"

namespace palpate {

/// Where the graphic tool may start for a haptic pose: at X_WH itself if that is free, else at a
/// free pose near it.
/// @field depth  distance from X_WH to X_WG [m]; 0 where X_WH is free.
struct StartPose {
  Pose X_WG;
  double depth = 0.0;
};

/// Resolves a start in penetration.  Not real-time (milliseconds): called before forces begin.
/// `wear`, `cuts`: what has gone, as in a StepState; null and empty: nothing has.
StartPose ResolveStart(const HapticModel& model, const Pose& X_WH, StepWorkspace& workspace,
                       const LeafWear* wear = nullptr, std::span<const CutField> cuts = {});

}  // namespace palpate
