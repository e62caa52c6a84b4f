#pragma once

#include <array>

#include "common/math/pose.h"
#include "server/physics/haptic_model.h"
#include "server/physics/rows/contact_rows.h"
#include "server/physics/solve/qp_solver.h"
#include "server/physics/solve/response.h"
#include "server/physics/step_state.h"
#include "server/physics/step_types.h"

namespace palpate {

/// What friction and reports need of a contact beyond its row.
/// @field lever        from the tool's reference point to the point where it touches, in W [m].
/// @field object_leaf  of the forest: whose material counts.
struct ContactPlace {
  Vec3 lever;
  std::int32_t object_leaf;
};

/// Where a row touches: the one place that knows what the pair of a row means.
/// @param R_WG  orientation of the tool; between surfaces that of the prediction counts.
ContactPlace PlaceOf(const HapticModel& model, const ContactRows& rows, int row,
                     const Mat3& R_WG) noexcept;

/// Cycles without slip after which a contact holds with mu_s again.  Static friction needs a time
/// of rest (Dieterich 1972); without one, a hand that trembles while it slides would stick at every
/// turn of its tremble.
inline constexpr int kStillCycles = 20;

/// Friction forces on the tool, one for each active row of a QpResult, perpendicular to its normal,
/// in W [m]: times k_t, newtons.
using FrictionForces = std::array<Vec3, kMaxActiveRows>;

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
/// sub-step on, until kStillCycles cycles have passed without slip.
///
/// Method: augmented Lagrangian (Alart & Curnier, Comput. Methods Appl. Mech. Engrg. 92 (1991)
/// 353-375) with a semi-smooth Newton method in the 3 or 6 unknowns x.  Its friction forces then
/// shift the target of the QP over all rows, so that a row is never violated for friction's sake;
/// rows that this brings in join the contacts, and Newton's method goes on.
///
/// @param rigid  of `rows`: what no step may violate; where some are soft, the target is that which
///               their push at the frictionless optimum shifts (soft contacts are smooth).
/// @param first_substep  of its cycle: cycles are counted there.
/// @param qp   in: the frictionless optimum, with an active row.  Out: the frictional one; its
///             active rows are all that carry force.
/// @param forces  out, of those rows.
/// Where it does not converge, that is counted in the report, and the best iterate is taken: rows
/// hold and forces add up all the same.
/// Real-time: no allocation, lock, log or clock.  Deterministic: equal inputs, equal bits.
void AddCoulombFriction(const HapticModel& model, const Kernels& kernels, const Mat3& R_WG,
                        const Target& target, const ContactRows& rows, const QpRows& rigid,
                        bool first_substep, FrictionState& state, QpResult& qp,
                        FrictionForces& forces, StepReport& report) noexcept;

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

/// To be called where no row is active: what touches next has not slipped.
inline void ForgetFriction(FrictionState& state) noexcept {
  state.still = kStillCycles;
  state.resets = 0;
  state.contacts = 0;
}

}  // namespace palpate
