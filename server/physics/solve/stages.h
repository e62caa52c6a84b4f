#pragma once

#include "server/physics/solve/step_context.h"

namespace palpate {

// The stages of a step from rows to a report, in the order in which haptic_step.cpp calls them.
// Real-time: no allocation, lock, log or clock.  Deterministic: equal inputs, equal bits.

/// Returns the bounds of a cycle's first sub-step: kBoundsOverHand times what the hand moved, plus
/// a margin.  While the same contacts hold, the step nearest to the hand moves no farther than the
/// hand does; if it must (a ledge ends, a jump), later sub-steps have wider bounds.  Tight bounds
/// mean few rows.  Between meshes, rotation adds nothing to the bound on translation, nor the other
/// way round: a candidate that is cut short costs only one sub-step, and a row that a wider
/// candidate asks for may block a nearer one.
/// @param hand_step  what the hand moved since the last cycle
StepBounds FirstBounds(const HapticModel& model, const Target& hand_step) noexcept;
/// Returns bounds that are no wider than the widest, and no narrower than the separation over
/// these: a motion that short has as many near pairs as none.
StepBounds Clamped(const StepParameters& parameters, const StepBounds& bounds) noexcept;
/// Returns the bounds of the next sub-step: kWiden times wider, up to the widest.  Between meshes,
/// no wider than its queries pay for; they grow with its length.
/// @param bounds    of the last sub-step
/// @param fraction  of the last sub-step's candidate that was free: if not all was, the next bounds
///                  are that fraction of the last ones
/// @param paid      queries that the next sub-step may spend, over those that the last one spent
StepBounds NextBounds(const StepParameters& parameters, const StepBounds& bounds, double fraction,
                      double paid) noexcept;
/// Returns the greatest fraction of a step, at most 1, that stays inside the bounds that the
/// prediction covers.
double FractionWithin(const StepBounds& bounds, const Vec3& v, const Vec3& phi) noexcept;

/// Predicts the rows between leaves.  If many come within the bounds of a rigid tool, as between
/// smooth bodies that lie along each other, only the last cycle's contacts give rows at first:
/// the others follow from where the tool goes (Foresees).
void PredictLeaves(StepContext& context) noexcept;
/// Returns whether the rows between leaves cover the end of the candidate.  If not, predicts those
/// near it: the optimum must then be solved again.
bool Foresees(StepContext& context) noexcept;

/// Returns the step nearest to a target under the context's rigid rows and, if asked for, the
/// energies that act beside the coupling's.  The solver's first guess is the sub-step's active
/// rows.
Optimum NearestStep(StepContext& context, const Target& target,
                    bool with_energies = false) noexcept;

/// NearestStep for each tool, from its `goal` to `nearest`; those of several tools together, under
/// the rows of all.
/// @param with_energies  of a lone tool
void NearestSteps(Party tools, bool with_energies = false) noexcept;

/// Returns in each tool's `nearest.qp` the point y nearest to t under the rows of all tools,
/// without energies.  With w_i a tool's `weight`, y has the blocks sqrt(w_i) x_i, x_i = [v; rho
/// phi], or a body's ToUnknowns: the energies over k_t of the first are 1/2 |y - t|^2.  `guess`: as
/// SolveNearestPoint's.
void SolveRows(Party tools, const double* t, std::span<const ToolRow> guess) noexcept;
/// Returns whether the rows that SolveRows solved for hold at y.
bool RowsHold(Party tools, const double* y, double tolerance) noexcept;

/// Corrects the optimum of a ball under straight rows for rows that turn about an edge or corner of
/// a mesh.  Returns false, without a change, if no row turns.  (Drawing: contact/README.md.)
///
/// With the rows' second order, g_i(x) = g_i + n_i . x + 1/2 x . K_i x >= 0, K_i = CurvatureOf, the
/// multipliers l_i of the optimum give x - t = sum l_i (n_i + K_i x): x is nearest to the target
/// t + sum l_i K_i x.  For a single edge its direction is exact.
bool RoundCreases(StepContext& context, Optimum& optimum) noexcept;

/// Moves the optimum of each tool's advance to the frictional one (FrictionModel::kCoulomb).
/// friction.md has the problem, the method and its reasons.
///
/// In: the frictionless optima, with at least one active row; if some rows are soft, the target is
/// shifted by their push there (soft contacts are smooth).  Out: their active rows are all those
/// that carry force.
/// Changes the contexts' friction.  Counts cycles in the first sub-step of each.  If it does not
/// converge, the optimum says so, and the last cycle's forces are used within the limits that the
/// normal forces give; rows hold and forces add up even then.
void AddCoulombFriction(Party tools) noexcept;

/// Stores the rows that hold the tool at an optimum, except for those that are loose: the solver's
/// next first guess.
void Remember(StepContext& context, const Optimum& optimum) noexcept;

/// Computes the motions of a sub-step towards the optima, as far as the bounds and the meshes allow
/// them.  Returns false if rows changed: the optima must then be solved again.
///
/// If only leaves touch, the rows cover everything within the bounds.  Between meshes rows are
/// added on violation, so a motion is made only after it was checked: the meshes are apart at its
/// end and were apart throughout.  If rows follow the candidates without success, they begin again
/// in a trust region a quarter as wide.  If a motion is still not free in the end, it is halved
/// until it is; the zero motion always is.  The tool counts as arrived only if the pairs that hold
/// it touch.
///
/// Each tool's `advance`, in: its optimum.  Out: its motion, if true; another optimum if that is
/// freer.
bool MakeAdvance(Party tools) noexcept;

/// Says where the frames of the model's groups are to be at the end of this step.
void AimFrames(const HapticModel& model, StepState& state) noexcept;
/// Returns by how much the frames are to move and turn in this step, at most, where the tool is
/// [m], [rad].
/// A frame whose next pose is not usable stays, with kFaultBadPose.
StepBounds MotionOfFrames(StepContext& context) noexcept;
/// Begins a sub-step of the frames: they make what their motion has left, or the part of it that a
/// tool which they push can follow within the bounds; or they stand.
void BeginFrames(Party tools, bool move) noexcept;
/// Sets the frames' motion in the sub-step to a fraction of that part.
void PlaceFrames(StepContext& context, double fraction) noexcept;
/// Sets the motion of those frames that are other tools to the candidates of these.
void PlaceTools(Party tools) noexcept;
/// Moves the frames with the advance: where the tool cannot give way, all stop.  Returns whether
/// all are where they are to be.
bool MoveFrames(StepContext& context) noexcept;

/// For all frames of bodies, CheckCandidate and GiveUpRegain of contact/sub_step.h.
bool CheckCandidate(Party tools) noexcept;
bool GiveUpRegain(Party tools) noexcept;
/// Returns whether the candidates end no farther from the hands than they begin: in sum, each by
/// its spring's energy.  A step that stays within the reach of contact may pay for separation that
/// it regains.  A body that moves may push a tool away.
bool AdvancesApproach(Party tools) noexcept;

/// Writes the contacts at the optimum into the context's report, relative to where the advance has
/// taken the tool: each contact's force, the gap that its row has left there, and where it touches.
void ReportContacts(StepContext& context) noexcept;
/// Then adds to each tool's report the contacts that it has by rows of other tools.
void ReportTouches(Party tools) noexcept;

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
///   contact point (2.32).  p_g is the tool's reference point.
/// - k_e and k_tau are the coupling's stiffnesses, so that the models compare.
/// - A single sphere has no rotation of its own: 2.31-2.33 do not apply.
/// - What friction adds to the force is distributed over the contacts by their normal forces (for
///   the report only: the chapter has no force per contact).
/// @param X_before  graphic tool at the end of the last cycle
/// @param state     in: the end of the cycle without friction.  Out: reset, if 2.34 requires it.
/// @param report    wrench, contacts and friction_resets are changed
void AddChapterFriction(const HapticModel& model, const Pose& X_before, StepState& state,
                        StepReport& report) noexcept;

}  // namespace palpate
