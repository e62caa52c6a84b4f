#pragma once

#include <cstdint>
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

/// Returns whether a tool at X_WT meets another member of its scene (StepTogether), of which its
/// model knows, and which is at X_WB.  Real-time: some hundred microseconds at most.
bool Meet(const HapticModel& model, const Pose& X_WT, std::int32_t tool, const Pose& X_WB,
          StepWorkspace& workspace) noexcept;

/// Finds a start pose for a tool that may penetrate an object.  Not real-time (milliseconds);
/// called before forces begin.  Other tools count as not there.
/// `cuts`: what has been removed from the solids, as in StepState; empty means nothing.
StartPose ResolveStart(const HapticModel& model, const Pose& X_WH, StepWorkspace& workspace,
                       std::span<const CutField> cuts = {});

}  // namespace palpate
