#pragma once

#include "common/math/pose.h"
#include "server/physics/haptic_model.h"
#include "server/physics/solve/response.h"
#include "server/physics/step_types.h"

namespace palpate {

/// Returns the bounds of a cycle's first sub-step: kBoundsOverHand times what the hand moved, plus
/// a margin.  While the same contacts hold, the step nearest to the hand moves no farther than the
/// hand does; if it must (a ledge ends, a jump), later sub-steps have wider bounds.  Tight bounds
/// mean few rows.  Between meshes, rotation adds nothing to the bound on translation, nor the other
/// way round: a trial that is cut short costs only one sub-step, and a row that a wider trial asks
/// for may block a nearer one.
/// @param hand_step  what the hand moved since the last cycle
StepBounds FirstBounds(const HapticModel& model, const Target& hand_step) noexcept;

/// Returns the bounds of the next sub-step: kWiden times wider, up to the widest.
StepBounds WiderBounds(const HapticModel& model, const StepBounds& bounds) noexcept;

/// Returns the greatest part of a step, at most 1, that stays inside the bounds that the prediction
/// covers. With 3 degrees of freedom a rotation moves no sphere and needs no bound.
double PartWithin(const StepBounds& bounds, int degrees_of_freedom, const Vec3& v,
                  const Vec3& phi) noexcept;

}  // namespace palpate
