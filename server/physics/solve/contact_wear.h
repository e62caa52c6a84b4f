#pragma once

#include "common/math/pose.h"
#include "server/physics/haptic_model.h"
#include "server/physics/step_types.h"
#include "server/physics/tree/leaf_wear.h"

namespace palpate {

/// The wear of one step, for the contacts that its report lists: the work of the tangential force
/// over the slip of the tool at the contact, mu_d f |slip| with f the normal force and mu_d the
/// leaf's.  With friction off an edge is taken to bite: mu_d = 1.  What vanishes is written to the
/// report, and has no row from the next step on.  Real-time.
/// @param X_before  graphic tool before the step.
void WearContacts(const HapticModel& model, const Pose& X_before, LeafWear& wear,
                  StepReport& report) noexcept;

}  // namespace palpate
