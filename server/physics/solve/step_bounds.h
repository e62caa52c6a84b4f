#pragma once

#include "common/math/pose.h"
#include "server/physics/haptic_model.h"
#include "server/physics/solve/response.h"
#include "server/physics/step_types.h"

namespace palpate {

/// Bounds of a cycle's first sub-step: kBoundsOverHand times what the hand moved, and a little.  A
/// step nearest to the hand's moves no further than the hand does while the same contacts hold;
/// where it does (a ledge ends, a jump), the sub-steps after it have wider bounds.  Tight bounds
/// mean few rows.  Between meshes a rotation adds nothing to the bound on translation, nor the
/// other way round: a trial that is cut short costs but one sub-step, and a row that a wider trial
/// asks for may hold back a nearer one.
/// @param hand_step  what the hand moved since the last cycle.
StepBounds FirstBounds(const HapticModel& model, const Target& hand_step) noexcept;

/// Bounds of the next sub-step: kWiden times wider, up to the widest.
StepBounds WiderBounds(const HapticModel& model, const StepBounds& bounds) noexcept;

/// Greatest part, at most 1, of a step that stays inside the bounds that the prediction covers.
/// With 3 degrees of freedom a rotation moves no sphere and needs no bound.
double PartWithin(const StepBounds& bounds, int degrees_of_freedom, const Vec3& v,
                  const Vec3& phi) noexcept;

}  // namespace palpate
