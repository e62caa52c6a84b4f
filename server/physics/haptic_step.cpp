#include "server/physics/haptic_step.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/math/default_rounding.h"
#include "common/math/rotation.h"
#include "server/physics/contact/sub_step.h"
#include "server/physics/limits.h"
#include "server/physics/solve/response.h"
#include "server/physics/solve/stages.h"
#include "server/physics/solve/step_context.h"

namespace palpate {

StepWorkspace::StepWorkspace(const HapticModel& model)
    : buffers_(std::make_unique<StepBuffers>(model)) {}
StepWorkspace::~StepWorkspace() = default;
StepWorkspace::StepWorkspace(StepWorkspace&&) noexcept = default;

/// An edge starts or stops cutting only after it has been drawn some distance, so the tremor of a
/// resting hand does not toggle it.
bool CutsInStep(const HapticModel& model, const Pose& X_WH, StepState& state) noexcept {
  const Cutting* cutting = model.cutting();
  if (cutting == nullptr || !cutting->sense) return state.cut.spins;
  const Vec3 moved = X_WH * cutting->X_TB.p - state.X_WH * cutting->X_TB.p;
  state.cut.drawn = std::clamp(state.cut.drawn + moved.dot(X_WH.q * *cutting->sense), 0.0,
                               limits::cutting::kDraw);
  const double turned = state.cut.acts ? 0.0 : limits::cutting::kDraw;
  return state.cut.drawn == turned ? !state.cut.acts : state.cut.acts;
}

namespace {

bool IsFinite(const StepReport& report) {
  return report.wrench.force.allFinite() && report.wrench.torque.allFinite() &&
         report.X_WG.p.allFinite() && report.X_WG.q.coeffs().allFinite();
}

/// Sets the poses of the tools, and the first bounds.  Returns false if the pose is not usable;
/// the tool then stays.
bool Begin(const Pose& X_WH, StepContext& context) {
  StepState& state = context.state();
  context.report().X_WG = state.X_WG;
  const double norm2 = X_WH.q.squaredNorm();
  if (!std::isfinite(X_WH.p.x() + X_WH.p.y() + X_WH.p.z()) || !std::isfinite(norm2) ||
      !(norm2 > limits::kLeastSquaredNorm)) {
    context.report().faults = kFaultBadPose;
    return false;
  }
  const Vec3& reference = context.model.reference();
  Tools& tools = context.tools;
  tools.q_H = Quat(X_WH.q.coeffs() / std::sqrt(norm2));
  tools.p_H = X_WH.p + tools.q_H * reference;
  tools.q_G = state.X_WG.q;
  tools.p_G = state.X_WG.p + tools.q_G * reference;
  // No contact can turn a ball about its centre: it turns as the hand does, and its step is made
  // without a rotation.
  if (context.model.is_ball()) tools.q_G = tools.q_H;
  const Target hand_step = TargetOf(state.X_WH * reference, state.X_WH.q, tools.p_H, tools.q_H);
  StepBounds& bounds = context.sub_step.bounds;
  bounds = FirstBounds(context.model, hand_step);
  if (state.behind.translation > 0.0) bounds = state.behind;
  if (context.buffers().meshes) state.frames.resize(context.buffers().meshes->of.size());
  const auto [moved, turned] = MotionOfFrames(context);
  if (moved + turned > 0.0) {
    bounds =
        Clamped(context.model.parameters(), {bounds.translation + moved, bounds.rotation + turned});
  }
  const bool cuts = CutsInStep(context.model, {X_WH.p, tools.q_H}, state);
  state.X_WH = {X_WH.p, tools.q_H};
  if (cuts != state.cut.acts) {
    for (BodyFrame& frame : state.frames) frame.front.Clear();
  }
  state.cut.acts = cuts;
  if (context.buffers().meshes) {
    for (MeshContact& contact : context.buffers().meshes->of) {
      contact.meshes.solids = &state.solids;
      contact.meshes.cuts = cuts;
    }
    if (!state.solids.empty()) state.solids.Begin(state.cut.fields, state.frames.front().front);
  }
  return true;
}

/// Adds the rows of a bur at the beginning of a sub-step.
void BeginCutting(StepContext& context, double reach) {
  const std::span cuts =
      context.state().cut.acts ? std::span(context.state().cut.fields) : std::span<CutField>();
  context.buffers().energies->Begin({{context.tools.p_G, context.tools.q_G}, cuts, reach});
}

/// Returns whether another sub-step fits into the cycle.  Between leaves, and for a bur, it is
/// assumed to cost as much as the last one.
bool GoesOn(const StepContext& context) {
  const StepParameters& parameters = context.model.parameters();
  if (context.cost.cut_queries + context.cost.last_cut_queries > limits::cutting::kMostQueries) {
    return false;
  }
  if (parameters.queries - context.cost.queries < parameters.queries / 4) return false;
  return context.report().diagnostics.substeps < parameters.sub_steps && !context.outcome.arrived &&
         context.cost.packet_pairs + context.cost.last <= limits::kMaxTested &&
         !context.IsUnsolved();
}

/// Finds the rows between leaves that the sub-step must respect, both rigid and soft ones; and the
/// pairs of triangles that it could bring together, with the rows of those that touched last.
/// @param queries  of the sub-step, at most
void Predict(StepContext& context, First first, std::int64_t queries) {
  StepBuffers& buffers = context.buffers();
  Tools& tools = context.tools;
  SubStep& sub_step = context.sub_step;
  sub_step = {.bounds = sub_step.bounds,
              .active = context.state().active,
              .is_crowded = context.state().is_crowded};
  if (context.HasFriction()) context.friction = context.state().friction;
  context.Aim();
  tools.R_WG = tools.q_G.toRotationMatrix();
  if (buffers.energies) BeginCutting(context, std::numeric_limits<double>::infinity());
  PredictLeaves(context);
  if (buffers.meshes) {
    StageClock clock(context.times);
    buffers.meshes->queries = {.most = queries};
    BeginFrames(context, first != First::kTouching);
    for (MeshContact& contact : buffers.meshes->of) {
      FrameRows rows(buffers.rows, contact.moved);
      BeginSubStep(contact, context.kernels, context.FrameOf(contact).front,
                   context.ToolIn(contact), context.state().active, first, rows);
    }
    clock.Lap(&StageTimes::prediction);
  }
  context.report().diagnostics.predicted_pairs = buffers.rows.count();
}

/// Returns the nearest pose to the hand's that the rows allow, with straight
/// rows and without friction.
Optimum SolveWithoutFriction(StepContext& context) {
  StepBuffers& buffers = context.buffers();
  ++context.sub_step.iterates;
  buffers.rows.Finish();
  context.sub_step.rigid = buffers.rows.view();
  if (buffers.energies) buffers.energies->Collect(buffers.rows, context.sub_step.rigid);
  const bool with_energies = buffers.energies && buffers.energies->acts();
  Optimum optimum = NearestStep(context, context.sub_step.target, with_energies);
  if (buffers.meshes && !with_energies &&
      (optimum.qp.status == QpStatus::kRelaxed ||
       !context.Approaches(optimum, optimum.v, optimum.phi)) &&
      GiveUpRegain(context)) {
    optimum = NearestStep(context, context.sub_step.target);
  }
  context.report().diagnostics.qp_iterations += optimum.qp.iterations;
  return optimum;
}

/// Applies friction to an optimum, if the model has friction and a row is active.
void ApplyFriction(StepContext& context, Optimum& optimum) {
  FrictionState& friction = context.friction;
  if (!context.HasFriction()) return;
  // A prediction where the tool goes adds rows and keeps the contacts, so the last forces are
  // nearest.
  if (context.sub_step.predictions > 0) {
    friction.still = context.state().friction.still;
  } else if (context.sub_step.iterates > 1) {
    friction = context.state().friction;
  }
  if (optimum.qp.active == 0 || friction.suspended ||
      optimum.qp.status == QpStatus::kIterationLimit) {
    return;
  }
  AddCoulombFriction(context, optimum);
}

/// Returns the optimum, including the curvature of a ball's rows at creases, and friction if
/// the model has it.
Optimum Solve(StepContext& context) {
  Optimum optimum = SolveWithoutFriction(context);
  optimum.rounds = context.IsFreeBall() && RoundCreases(context, optimum);
  ApplyFriction(context, optimum);
  context.Require(optimum);
  if (!context.IsUnsolved()) Remember(context, optimum);
  return optimum;
}

/// Counts how the friction of an optimum that counts was solved.
void CountFriction(const Optimum& optimum, StepDiagnostics& diagnostics) {
  diagnostics.friction_unsolved += optimum.friction_unsolved ? 1 : 0;
  diagnostics.friction_yielded += optimum.friction_yielded ? 1 : 0;
}

/// Moves the tool and the frames, with what the state takes over; updates the fronts and the cut
/// solids.
void Move(StepContext& context, Advance& advance) {
  StepBuffers& buffers = context.buffers();
  const bool meshes = buffers.meshes.has_value();
  const bool is_held = advance.optimum.IsHeld();
  if (!MoveFrames(context, advance)) advance.arrived = false;
  context.outcome.arrived = advance.arrived;
  context.state().active = context.sub_step.active;
  context.state().is_crowded = context.sub_step.is_crowded;
  if (context.HasFriction()) context.state().friction = context.friction;
  CountFriction(advance.optimum, context.report().diagnostics);
  if (!is_held) context.state().rotation_G.setZero();
  if (meshes) {
    for (MeshContact& contact : buffers.meshes->of) {
      EndSubStep(contact, context.report().diagnostics.substeps == 0);
    }
    context.cost.queries += buffers.meshes->queries.Spent();
  }
  if (context.HasFriction() && advance.optimum.qp.active == 0 && (advance.arrived || !meshes)) {
    context.state().friction.Forget();
  }
  if (buffers.energies && context.state().cut.acts) {
    context.cost.last_cut_queries = buffers.energies->Cut(
        context.tools.p_G, context.tools.q_G, advance.v, advance.phi, context.state().cut.fields);
    context.cost.cut_queries += context.cost.last_cut_queries;
  }
  Tools& tools = context.tools;
  if (advance.arrived && !is_held) {
    tools.p_G = tools.p_H;
    tools.q_G = tools.q_H;
    return;
  }
  context.report().diagnostics.truncation =
      std::max(context.report().diagnostics.truncation,
               0.5 * advance.phi.squaredNorm() * context.model.tool().max_lever);
  tools.p_G += advance.v;
  tools.q_G = (RotationExp(advance.phi) * tools.q_G).normalized();
}

/// Reports the wrench of the spring at the optimum, and the contacts.
void ReportHeld(StepContext& context, const Advance& advance) {
  StepReport& report = context.report();
  const Optimum& optimum = advance.optimum;
  if (optimum.qp.status == QpStatus::kRelaxed) report.faults |= kFaultJammed;
  context.outcome.held = optimum.IsHeld();
  report.wrench = context.outcome.held ? context.WrenchAfter(optimum.v, optimum.phi) : Wrench{};
  ReportContacts(context, advance);
}

/// Sets the bounds of the next sub-step, and those of the next cycle if this one does not arrive.
/// @param fraction  of the last candidate that was free
void SetNextBounds(StepContext& context, double fraction) {
  const StepParameters& parameters = context.model.parameters();
  const StepBounds bounds = context.sub_step.bounds;
  const auto& meshes = context.buffers().meshes;
  const auto paid_by = [&](std::int64_t queries) {
    return meshes ? static_cast<double>(queries) / static_cast<double>(meshes->queries.Spent())
                  : kInfinity;
  };
  context.state().behind = NextBounds(parameters, bounds, fraction, paid_by(parameters.queries));
  double by = paid_by(parameters.queries - context.cost.queries);
  if (context.sub_step.trust.shrunk) by = std::min(by, limits::mesh::kRegrow);
  context.sub_step.bounds = NextBounds(parameters, bounds, fraction, by);
}

void ForgetForces(StepReport& report) {
  report.contacts = report.soft_contacts = 0;
  report.wrench = report.soft_wrench = Wrench{};
  report.bur_force.setZero();
}

/// Called if a QP did not end, or its result is not finite: the tool stays where it is, and the
/// spring pulls from there.  Intermediate results belong to no pose, so all of them are discarded.
void GiveUp(StepContext& context) {
  StepReport& report = context.report();
  context.outcome.arrived = false;
  context.state().active.count = 0;
  ForgetForces(report);
  context.Aim();
  report.wrench = context.WrenchAfter(Vec3::Zero(), Vec3::Zero());
}

/// Reports what is felt between meshes if the tool has not arrived: what its contacts hold of
/// the spring's pull where it is (solve/README.md, "The wrench of a tool that lags").
void Lag(StepContext& context) {
  Predict(context, First::kTouching, context.model.parameters().queries / limits::mesh::kReserve);
  // Material beyond where the tool may go next does not hold it yet.
  if (const auto& energies = context.buffers().energies) {
    BeginCutting(context, std::min(context.sub_step.bounds.translation, energies->bur_step()));
  }
  BodyContact& meshes = *context.buffers().meshes;
  for (MeshContact& contact : meshes.of) {
    FrameRows rows(context.buffers().rows, contact.moved);
    AddRowsOfHidden(contact, context.state().active, limits::mesh::kLagAhead, rows);
  }
  const double reach = meshes.a().mesh.reach();
  double far = meshes.margins().touching;
  Advance stays;
  for (int i = 0; i < context.model.parameters().iterates; ++i) {
    // The tool's place is free, even if its contacts ask for more separation than it has.  So the
    // wrench is never more than the spring's own.
    context.buffers().rows.AdmitZero();
    stays.optimum = SolveWithoutFriction(context);
    context.Require(stays.optimum);
    if (context.IsUnsolved()) return GiveUp(context);
    if (meshes.queries.AreSpent()) break;  // no candidate would find more
    const double fraction = FractionWithin({far, far / reach}, stays.optimum.v, stays.optimum.phi);
    if (!CheckCandidate(context, fraction * stays.optimum.v, fraction * stays.optimum.phi)) {
      continue;
    }
    if (fraction == 1.0 || far == limits::mesh::kLagAhead) break;
    far = limits::mesh::kLagAhead;
  }
  Remember(context, stays.optimum);
  context.state().active = context.sub_step.active;
  if (context.HasFriction()) {
    ApplyFriction(context, stays.optimum);  // the state keeps what it had
    context.Require(stays.optimum);
    if (context.IsUnsolved()) return GiveUp(context);
    CountFriction(stays.optimum, context.report().diagnostics);
  }
  ReportHeld(context, stays);
}

/// Computes the drag of the spin on a pushing bur, for the next step, smoothed so that a bur in a
/// hole does not whirl (cut/README.md).
void TakeDrag(StepContext& context) {
  const auto& energies = context.buffers().energies;
  const CutRows* bur = energies ? energies->bur() : nullptr;
  Vec6& drag = context.state().cut.drag;
  if (bur == nullptr) {
    drag.setZero();
  } else {
    drag += limits::cutting::kDragShare * (bur->Drag() - drag);
  }
}

/// Adds the vibration of the handle as teeth pass, as a share of the material's force on the bur.
/// It is a triangle wave, because libm's sine differs between processors.  It moves nothing.
void Vibrate(StepContext& context) {
  const Cutting* cutting = context.model.cutting();
  if (cutting == nullptr || cutting->spin.vibration == 0.0 || !context.state().cut.acts) return;
  double& tooth = context.state().cut.tooth;
  tooth += cutting->spin.tooth_Hz * cutting->period;
  tooth -= std::floor(tooth);
  const double shake = cutting->spin.vibration * (4.0 * std::abs(tooth - 0.5) - 1.0);
  context.report().wrench.force += shake * context.report().bur_force;
}

/// Adds the effects' wrenches, whether the tool touches anything or not.  They are summed first, so
/// that without contact the wrench is exactly their sum.
void AddEffects(StepContext& context) {
  const Effects& effects = context.model.effects();
  if (effects.empty()) return;
  StepState& state = context.state();
  EffectWrenches& given = context.report().effects;
  if (!effects.Step(state.X_WH, state.X_WG, context.model.reference(), state.effects, given)) {
    context.report().faults |= kFaultEffect;
  }
  context.report().wrench.force += given.passive.force + given.active.force;
  context.report().wrench.torque += given.passive.torque + given.active.torque;
}

/// Stores what the next step starts from, and applies friction by the chapter's rule.
void End(const Pose& X_WH, StepContext& context) {
  const Features& features = context.model.parameters().features;
  StepState& state = context.state();
  StepReport& report = context.report();
  if (!context.outcome.arrived && !context.IsUnsolved()) report.faults |= kFaultTargetFar;
  if (report.diagnostics.friction_unsolved > 0) report.faults |= kFaultFriction;
  const bool lags = context.buffers().meshes && !context.outcome.arrived;
  if (!lags) state.behind = {0.0, 0.0};
  if (context.outcome.arrived && !context.outcome.held) {
    state.X_WG = {X_WH.p, context.tools.q_H};
  } else {
    state.X_WG = {context.tools.p_G - context.tools.q_G * context.model.reference(),
                  context.tools.q_G};
  }
  const Pose X_before = report.X_WG;
  if (features.friction == FrictionModel::kChapter && context.outcome.arrived &&
      !state.friction.suspended) {
    AddChapterFriction(context.model, X_before, state, report);
  }
  report.X_WG = state.X_WG;
  if (!state.solids.empty()) state.solids.Follow(state.cut.fields, state.frames.front().front);
  TakeDrag(context);
  Vibrate(context);
  AddEffects(context);
  // Whatever came in, only finite numbers go out.
  if (!IsFinite(report)) {
    state.X_WG = report.X_WG = X_before;
    state.ForgetContact();
    ForgetForces(report);
    report.effects = {};
    report.faults |= kFaultUnsolved;
  }
}

/// HapticStep, under default rounding.
[[gnu::noinline]] StepReport Step(const HapticModel& model, const Pose& X_WH, StepState& state,
                                  StepWorkspace& workspace, StageTimes* times) noexcept {
  StepReport report;
  report.parameters = &model.parameters();
  StepContext context(model, state, workspace.buffers(), report);
  context.times = times;
  if (!Begin(X_WH, context)) return report;
  const bool meshes = context.buffers().meshes.has_value();
  for (; GoesOn(context); ++report.diagnostics.substeps) {
    // In a cycle's later sub-steps the tool is at a new place, which other contacts may hold.
    Predict(context,
            context.HasFriction()             ? First::kAllCorners
            : report.diagnostics.substeps > 0 ? First::kContacts
                                              : First::kActive,
            model.parameters().queries - context.cost.queries);
    StageClock clock(times);
    for (bool is_clear = false; !is_clear && !context.IsUnsolved();) {
      Advance advance{Solve(context)};
      clock.Lap(&StageTimes::solve);
      if (context.IsUnsolved()) break;
      is_clear = MakeAdvance(context, advance);
      clock.Lap(&StageTimes::rows);
      if (!is_clear || context.IsUnsolved()) continue;
      Move(context, advance);
      if (!meshes || advance.arrived) ReportHeld(context, advance);
      SetNextBounds(context, advance.fraction);
    }
    if (context.IsUnsolved()) GiveUp(context);
    clock.Lap(&StageTimes::response);
  }
  if (meshes && !context.outcome.arrived && !context.IsUnsolved()) Lag(context);
  End(X_WH, context);
  return report;
}

}  // namespace

StepReport HapticStep(const HapticModel& model, const Pose& X_WH, StepState& state,
                      StepWorkspace& workspace, StageTimes* times) noexcept {
  const DefaultRounding rounding;
  return Step(model, X_WH, state, workspace, times);
}

}  // namespace palpate
