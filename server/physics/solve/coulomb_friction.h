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
/// mu_i is mu_s while the tool sticks, mu_d while it slides: one state for the whole tool, because
/// a rigid body that slips anywhere slips everywhere but on an axis; it needs no matching of
/// contacts, whose pairs change as the tool slides.  A cycle that begins stuck gives mu_d to each
/// contact that mu_s does not hold and solves again; if any slipped, all are sliding from the next
/// sub-step on, until StepParameters::still_cycles cycles have passed without slip.
///
/// Method: augmented Lagrangian (Alart & Curnier, Comput. Methods Appl. Mech. Engrg. 92 (1991)
/// 353-375) with a semi-smooth Newton method in the 3 or 6 unknowns x.  Its friction forces then
/// shift the target of the QP over all rows, so that a row is never violated for friction's sake;
/// rows that this brings in join the contacts, and Newton's method goes on.
///
/// @param optimum  the frictionless one, which has an active row; where some rows are soft, the
///                 target is that which their push there shifts (soft contacts are smooth).  Its
///                 active rows are then all that carry force.
/// Changes the state's friction.  Counts cycles in the first sub-step of each.
/// Where it does not converge, that is counted in the report, and the best iterate is taken: rows
/// hold and forces add up all the same.
/// Real-time: no allocation, lock, log or clock.  Deterministic: equal inputs, equal bits.
void AddCoulombFriction(StepContext& context, Optimum& optimum) noexcept;

}  // namespace palpate
