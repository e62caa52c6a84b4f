#pragma once

#include "server/physics/solve/step_context.h"

namespace palpate {

/// Computes the frictional optimum of a sub-step (FrictionModel::kCoulomb): x = [v; rho phi]
/// minimises
///   1/2 |x - t|^2 + sum_i mu_i lambda_i |S_i x|   subject to all rows.
/// S_i x = (1 - n n^T)(v + phi x l_i) is the slip of contact i, with l_i the lever of the point
/// where it touches.  lambda_i is the multiplier of its row at this same x, so that every force
/// lies in its own cone: |f_i| <= mu_i lambda_i, and f_i = -mu_i lambda_i S_i x / |S_i x| if it
/// slips. (With lambda from the frictionless solve, a contact that friction unloads would keep
/// rubbing, and a lever that friction turns would rub too little.)
///
/// mu_i is mu_s while the tool sticks and mu_d while it slides, with one state for the whole tool.
/// The method is an augmented Lagrangian with a semi-smooth Newton method (Alart & Curnier, Comput.
/// Methods Appl. Mech. Engrg. 92 (1991) 353-375).  Its friction forces then shift the target of the
/// QP over all rows, so friction never violates a row.  friction.md has the method and its reasons.
///
/// @param optimum  in: the frictionless optimum, with at least one active row; if some rows are
///                 soft, the target is shifted by their push there (soft contacts are smooth).
///                 Out: its active rows are all those that carry force.
/// Changes the state's friction.  Counts cycles in the first sub-step of each.
/// If it does not converge, the report counts that and the best iterate is used; rows hold and
/// forces add up even then.
/// Real-time: no allocation, lock, log or clock.  Deterministic: equal inputs, equal bits.
void AddCoulombFriction(StepContext& context, Optimum& optimum) noexcept;

/// Adds friction by FrictionModel::kChapter: 2.25-2.34 as written, for reproduction, once at the
/// end of a cycle whose frictionless step has arrived.  Compares how far the equivalent contact
/// point (the mean of the contact points, 2.26) moved since the last cycle with how deep the hand
/// is below it. Then either resets the graphic tool to where it was (2.34), or lets it move on and
/// uses mu_d / mu_s of the movement for the wrench (2.28-2.33).
///
/// Where the text leaves a choice:
/// - After a step that is not reset, the next one starts from the frictionless pose, not from p*_g,
///   which 2.28 uses for the force alone.
/// - mu_s and mu_d are means over the contacts, as the contact point is.
/// - The rotation axis is the screw axis of the movement, with the distance from its nearest
/// contact
///   point (2.32).  p_g is the tool's reference point.
/// - k_e and k_tau are the coupling's stiffnesses, so that the models compare.
/// - A single sphere has no rotation of its own: 2.31-2.33 do not apply.
/// - What friction adds to the force is distributed over the contacts by their normal forces (for
/// the
///   report only: the chapter has no force per contact).
/// @param X_before  graphic tool at the end of the last cycle
/// @param state     in: the end of the cycle without friction.  Out: reset, if 2.34 requires it.
/// @param report    wrench, contacts and friction_resets are changed
/// Real-time: no allocation, lock, log or clock.  Deterministic: equal inputs, equal bits.
void AddChapterFriction(const HapticModel& model, const Pose& X_before, StepState& state,
                        StepReport& report) noexcept;

}  // namespace palpate
