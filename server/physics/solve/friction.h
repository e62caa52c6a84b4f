#pragma once

#include "server/physics/solve/step_context.h"

namespace palpate {

/// The frictional optimum of a sub-step (FrictionModel::kCoulomb): x = [v; rho phi] minimises
///   1/2 |x - t|^2 + sum_i mu_i lambda_i |S_i x|   subject to all rows,
/// S_i x = (1 - n n^T)(v + phi x l_i) the slip of contact i, l_i the lever of the point where it
/// touches, and lambda_i the multiplier of its row at this same x, so that every force lies in its
/// own cone: |f_i| <= mu_i lambda_i, and f_i = -mu_i lambda_i S_i x / |S_i x| where it slips.
/// (With lambda from the frictionless solve, a contact that friction unloads
/// would go on rubbing, and a lever that friction turns would not rub enough.)
///
/// mu_i is mu_s while the tool sticks, mu_d while it slides: one state for the whole tool.  By an
/// augmented Lagrangian and a semi-smooth Newton method (Alart & Curnier, Comput. Methods Appl.
/// Mech. Engrg. 92 (1991) 353-375), whose friction forces then shift the target of the QP over all
/// rows: no row is violated for friction's sake.  friction.md has the method and its reasons.
///
/// @param optimum  the frictionless one, which has an active row; where some rows are soft, the
///                 target is that which their push there shifts (soft contacts are smooth).  Its
///                 active rows are then all that carry force.
/// Changes the state's friction.  Counts cycles in the first sub-step of each.
/// Where it does not converge, that is counted in the report, and the best iterate is taken: rows
/// hold and forces add up all the same.
/// Real-time: no allocation, lock, log or clock.  Deterministic: equal inputs, equal bits.
void AddCoulombFriction(StepContext& context, Optimum& optimum) noexcept;

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
