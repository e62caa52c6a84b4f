#pragma once

#include "common/math/pose.h"
#include "server/physics/haptic_model.h"
#include "server/physics/step_state.h"
#include "server/physics/step_types.h"

namespace palpate {

/// FrictionModel::kChapter: 2.25-2.34 as written, for reproduction, once at the end of a cycle
/// whose frictionless step has arrived.  Compares how far the equivalent contact point (the mean of
/// the contact points, 2.26) moved since the last cycle with how deep the hand is below it, and
/// either resets the graphic tool to where it was (2.34) or lets it go on and takes mu_d / mu_s of
/// the movement for the wrench (2.28-2.33).
///
/// Where the text leaves a choice:
/// - After a step that is not reset the next one starts from the frictionless pose, not from p*_g,
///   which 2.28 uses for the force alone.
/// - mu_s and mu_d are the means over the contacts, as the contact point is.
/// - The rotation axis is the screw axis of the movement, and its distance from the nearest contact
///   point counts (2.32).  p_g is the tool's reference point.
/// - k_e and k_tau are the coupling's stiffnesses, so that the models compare.
/// - A single sphere has no rotation of its own: 2.31-2.33 do not apply.
/// - What friction adds to the force is spread over the contacts by their normal forces (for the
///   report: the chapter knows no force per contact).
/// @param X_before  graphic tool at the end of the last cycle.
/// @param state     in: the cycle's end without friction.  Out: reset, where 2.34 says so.
/// @param report    wrench, contacts and friction_resets are changed.
/// Real-time: no allocation, lock, log or clock.  Deterministic: equal inputs, equal bits.
void AddChapterFriction(const HapticModel& model, const Pose& X_before, StepState& state,
                        StepReport& report) noexcept;

}  // namespace palpate
