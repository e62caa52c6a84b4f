#include "server/physics/haptic_step.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "common/error.h"
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
  if (const auto& meshes = context.buffers().meshes;
      meshes && state.frames.size() != meshes->of.size()) {
    state.MakeFrames(context.model.bodies());
  }
  AimFrames(context.model, state);
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
/// @param share  of the queries that a cycle may cost: those of the sub-step, at most; of 0, what
///               is left
void Predict(Party tools, First first, std::int64_t share = 0) {
  for (StepContext* tool : tools) {
    StepContext& context = *tool;
    context.sub_step = {.bounds = context.sub_step.bounds,
                        .active = context.state().active,
                        .is_crowded = context.state().is_crowded};
    if (context.HasFriction()) context.friction = context.state().friction;
    context.Aim();
    context.tools.R_WG = context.tools.q_G.toRotationMatrix();
    context.advance.v.setZero();
    context.advance.phi.setZero();
    if (context.buffers().energies) {
      BeginCutting(context, std::numeric_limits<double>::infinity());
    }
    PredictLeaves(context);
  }
  if (Lead(tools).buffers().meshes) {
    StageClock clock(Lead(tools).times);
    BeginFrames(tools, first != First::kTouching);
    PlaceTools(tools);
    for (StepContext* tool : tools) {
      BodyContact& meshes = *tool->buffers().meshes;
      const std::int64_t queries = tool->model.parameters().queries;
      meshes.queries = {.most = share > 0 ? queries / share : queries - tool->cost.queries};
      for (MeshContact& contact : meshes.of) {
        FrameRows rows(tool->buffers().rows, contact.moved);
        BeginSubStep(contact, tool->kernels, tool->FrameOf(contact).front, tool->ToolIn(contact),
                     tool->state().active, first, rows);
      }
    }
    clock.Lap(&StageTimes::prediction);
  }
  for (StepContext* tool : tools) {
    tool->report().diagnostics.predicted_pairs = tool->buffers().rows.count();
  }
}

/// Finds the nearest poses to the hands' that the rows allow, with straight rows and without
/// friction: each tool's `advance` begins at its optimum.
void SolveWithoutFriction(Party tools) {
  bool with_energies = false, meshes = false, is_relaxed = false;
  for (StepContext* tool : tools) {
    StepBuffers& buffers = tool->buffers();
    ++tool->sub_step.iterates;
    buffers.rows.Finish();
    tool->sub_step.rigid = buffers.rows.view();
    tool->goal = tool->sub_step.target;
    if (buffers.energies) buffers.energies->Collect(buffers.rows, tool->sub_step.rigid);
    with_energies |= buffers.energies && buffers.energies->acts();
    meshes |= buffers.meshes.has_value();
  }
  const auto solve = [&](bool energies) {
    NearestSteps(tools, energies);
    for (StepContext* tool : tools) {
      tool->advance = {tool->nearest, tool->nearest.v, tool->nearest.phi};
      is_relaxed = tool->nearest.qp.status == QpStatus::kRelaxed;
    }
  };
  solve(with_energies);
  if (meshes && !with_energies && (is_relaxed || !AdvancesApproach(tools)) && GiveUpRegain(tools)) {
    solve(false);
  }
  for (StepContext* tool : tools) {
    tool->report().diagnostics.qp_iterations += tool->advance.optimum.qp.iterations;
  }
}

/// Applies friction to the optima, if the model has friction and a row is active.
void ApplyFriction(Party tools) {
  if (!Lead(tools).HasFriction()) return;
  bool any = false, all = true;
  for (StepContext* tool : tools) {
    // A prediction where the tool goes adds rows and keeps the contacts, so the last forces are
    // nearest.
    if (tool->sub_step.predictions > 0) {
      tool->friction.still = tool->state().friction.still;
    } else if (tool->sub_step.iterates > 1) {
      tool->friction = tool->state().friction;
    }
    const Optimum& optimum = tool->advance.optimum;
    any |= optimum.qp.active > 0;
    all &= !tool->friction.suspended && optimum.qp.status != QpStatus::kIterationLimit;
  }
  if (any && all) AddCoulombFriction(tools);
}

/// Finds the optima, including the curvature of a ball's rows at creases, and friction if the model
/// has it.
void Solve(Party tools) {
  SolveWithoutFriction(tools);
  for (StepContext* tool : tools) {
    Optimum& optimum = tool->advance.optimum;
    optimum.rounds = tools.size() == 1 && tool->IsFreeBall() && RoundCreases(*tool, optimum);
  }
  ApplyFriction(tools);
  for (StepContext* tool : tools) {
    tool->Require(tool->advance.optimum);
    if (!tool->IsUnsolved()) Remember(*tool, tool->advance.optimum);
  }
}

/// Counts how the friction of an optimum that counts was solved.
void CountFriction(const Optimum& optimum, StepDiagnostics& diagnostics) {
  diagnostics.friction_unsolved += optimum.friction_unsolved ? 1 : 0;
  diagnostics.friction_yielded += optimum.friction_yielded ? 1 : 0;
}

/// Moves the tool and the frames, with what the state takes over; updates the fronts and the cut
/// solids.
void Move(StepContext& context) {
  Advance& advance = context.advance;
  StepBuffers& buffers = context.buffers();
  const bool meshes = buffers.meshes.has_value();
  const bool is_held = advance.optimum.IsHeld();
  if (!MoveFrames(context)) advance.arrived = false;
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
void ReportHeld(StepContext& context) {
  StepReport& report = context.report();
  const Optimum& optimum = context.advance.optimum;
  if (optimum.qp.status == QpStatus::kRelaxed) report.faults |= kFaultJammed;
  context.outcome.held = optimum.IsHeld();
  report.wrench = context.outcome.held ? context.WrenchAfter(optimum.v, optimum.phi) : Wrench{};
  ReportContacts(context);
}

/// Sets the bounds of the next sub-step, and those of the next cycle if this one does not arrive.
void SetNextBounds(StepContext& context) {
  const double fraction = context.advance.fraction;  // of the last candidate that was free
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

void GiveUp(Party tools) {
  for (StepContext* tool : tools) GiveUp(*tool);
}

/// Reports what is felt between meshes if the tools have not arrived: what their contacts hold of
/// the springs' pulls where they are (solve/README.md, "The wrench of a tool that lags").
void Lag(Party tools) {
  Predict(tools, First::kTouching, limits::mesh::kReserve);
  for (StepContext* tool : tools) {
    // Material beyond where the tool may go next does not hold it yet.
    if (const auto& energies = tool->buffers().energies) {
      BeginCutting(*tool, std::min(tool->sub_step.bounds.translation, energies->bur_step()));
    }
    for (MeshContact& contact : tool->buffers().meshes->of) {
      FrameRows rows(tool->buffers().rows, contact.moved);
      AddRowsOfHidden(contact, tool->state().active, limits::mesh::kLagAhead, rows);
    }
  }
  const StepContext& lead = Lead(tools);
  double far = lead.buffers().meshes->margins().touching;
  for (int i = 0; i < lead.model.parameters().iterates; ++i) {
    // The tools' places are free, even if their contacts ask for more separation than they have.
    // So a wrench is never more than the spring's own.
    for (StepContext* tool : tools) tool->buffers().rows.AdmitZero();
    SolveWithoutFriction(tools);
    double fraction = 1.0;
    for (StepContext* tool : tools) {
      tool->Require(tool->advance.optimum);
      const double reach = tool->buffers().meshes->a().mesh.reach();
      fraction = std::min(fraction,
                          FractionWithin({far, far / reach}, tool->advance.v, tool->advance.phi));
    }
    if (AreUnsolved(tools)) return GiveUp(tools);
    const auto is_spent = [](const StepContext* tool) {
      return tool->buffers().meshes->queries.AreSpent();
    };
    if (std::ranges::any_of(tools, is_spent)) break;  // no candidate would find more
    for (StepContext* tool : tools) {
      tool->advance.v *= fraction;
      tool->advance.phi *= fraction;
    }
    if (!CheckCandidate(tools)) continue;
    if (fraction == 1.0 || far == limits::mesh::kLagAhead) break;
    far = limits::mesh::kLagAhead;
  }
  for (StepContext* tool : tools) {
    Remember(*tool, tool->advance.optimum);
    tool->state().active = tool->sub_step.active;
    tool->advance.v.setZero();
    tool->advance.phi.setZero();
  }
  ApplyFriction(tools);  // the state keeps what it had
  for (StepContext* tool : tools) {
    tool->Require(tool->advance.optimum);
    CountFriction(tool->advance.optimum, tool->report().diagnostics);
  }
  if (AreUnsolved(tools)) return GiveUp(tools);
  for (StepContext* tool : tools) ReportHeld(*tool);
  ReportTouches(tools);
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
void End(StepContext& context) {
  const Features& features = context.model.parameters().features;
  StepState& state = context.state();
  StepReport& report = context.report();
  if (!context.outcome.arrived && !context.IsUnsolved()) report.faults |= kFaultTargetFar;
  if (report.diagnostics.friction_unsolved > 0) report.faults |= kFaultFriction;
  const bool lags = context.buffers().meshes && !context.outcome.arrived;
  if (!lags) state.behind = {0.0, 0.0};
  if (context.outcome.arrived && !context.outcome.held) {
    state.X_WG = {state.X_WH.p, context.tools.q_H};
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

/// The step of tools that have begun.
void Step(Party tools) {
  StepContext& lead = Lead(tools);
  const bool meshes = lead.buffers().meshes.has_value();
  for (; std::ranges::all_of(tools, [](const StepContext* tool) { return GoesOn(*tool); });) {
    // In a cycle's later sub-steps the tool is at a new place, which other contacts may hold.
    Predict(tools, lead.HasFriction()                       ? First::kAllCorners
                   : lead.report().diagnostics.substeps > 0 ? First::kContacts
                                                            : First::kActive);
    StageClock clock(lead.times);
    for (bool is_clear = false; !is_clear && !AreUnsolved(tools);) {
      Solve(tools);
      clock.Lap(&StageTimes::solve);
      if (AreUnsolved(tools)) break;
      is_clear = MakeAdvance(tools);
      clock.Lap(&StageTimes::rows);
      if (!is_clear || AreUnsolved(tools)) continue;
      for (StepContext* tool : tools) {
        Move(*tool);
        if (!meshes || tool->advance.arrived) ReportHeld(*tool);
        SetNextBounds(*tool);
      }
      if (Lead(tools).outcome.arrived) ReportTouches(tools);
    }
    if (AreUnsolved(tools)) GiveUp(tools);
    for (StepContext* tool : tools) ++tool->report().diagnostics.substeps;
    clock.Lap(&StageTimes::response);
  }
  if (meshes && !lead.outcome.arrived && !AreUnsolved(tools)) Lag(tools);
  for (StepContext* tool : tools) End(*tool);
}

/// HapticStep, under default rounding.
[[gnu::noinline]] StepReport StepAlone(const HapticModel& model, const Pose& X_WH, StepState& state,
                                       StepWorkspace& workspace, StageTimes* times) noexcept {
  StepReport report;
  report.parameters = &model.parameters();
  StepContext context(model, state, workspace.buffers(), report);
  context.times = times;
  StepContext* const alone[] = {&context};
  if (Begin(X_WH, context)) Step(alone);
  return report;
}

/// What a member of a step of several is in it.
struct Member {
  ToolStep* step;
  bool is_there = false, is_awake = false;
  Vec3 centre = Vec3::Zero();  ///< of a ball in which it stays in this step [m]
  double radius = 0.0;
  std::size_t island = 0;  ///< the least number of those that it can meet, through others
};
using Members = std::span<Member>;

bool IsBody(const Member& member) {
  return member.step->model->inertia() != nullptr;
}

/// Sets where an awake body would go alone, and widens its ball, as a hand's tool's, by the longest
/// motion of a step.
void Awake(Member& member) {
  ToolStep& step = *member.step;
  const StepParameters& limits = step.model->parameters();
  StepState& state = *step.state;
  if (IsBody(member)) {
    if (std::exchange(state.body.sleeps, false)) state.body.still = 0;
    step.X_WH = FreeMotion(*step.model->inertia(), state.X_WG, state.body, step.period);
  }
  member.is_awake = true;
  member.radius += limits.sub_steps * limits.widest_step;
}

Member MemberOf(ToolStep& step) {
  const HapticModel& model = *step.model;
  const MovingBody& body = *model.tool_body();
  Member member{.step = &step,
                .is_there = step.share > 0.0,
                .centre = step.state->X_WG * model.reference(),
                .radius = body.mesh.reach() + body.radius + model.parameters().separation};
  if (member.is_there && !step.state->body.sleeps) Awake(member);
  return member;
}

/// Joins what can meet in this step into islands, and wakes all bodies there: a pair is examined
/// only if both are solved together.  Hands are always in one island.
void MakeIslands(Members members) {
  for (std::size_t i = 0; i < members.size(); ++i) members[i].island = i;
  const auto join = [&](std::size_t a, std::size_t b) {
    const std::size_t low = std::min(a, b), high = std::max(a, b);
    for (Member& member : members) {
      if (member.island == high) member.island = low;
    }
  };
  const auto meet = [&](const Member& a, const Member& b) {
    if (!a.is_there || !b.is_there || (!a.is_awake && !b.is_awake)) return false;
    if (!IsBody(a) && !IsBody(b)) return true;
    return (a.centre - b.centre).norm() <= a.radius + b.radius;
  };
  for (bool grows = true; grows;) {  // who wakes may wake others
    grows = false;
    for (std::size_t i = 0; i < members.size(); ++i) {
      for (std::size_t j = i + 1; j < members.size(); ++j) {
        Member &a = members[i], &b = members[j];
        if (a.island == b.island || !meet(a, b)) continue;
        if (!a.is_awake) Awake(a);
        if (!b.is_awake) Awake(b);
        join(a.island, b.island);
        grows = true;
      }
    }
  }
}

/// Puts the frames that are members where these are.
void PlaceMembers(Members members) {
  for (Member& member : members) {
    for (const ContactBody& body : member.step->model->bodies()) {
      if (body.tool < 0 || !members[static_cast<std::size_t>(body.tool)].is_there) continue;
      BodyFrame& frame = member.step->state->frames[static_cast<std::size_t>(body.frame)];
      frame.X_WB = frame.X_WB_next = members[static_cast<std::size_t>(body.tool)].step->state->X_WG;
    }
  }
}

/// After a body's step: its velocity, and for how long it has been still.
void EndBody(Member& member, const Pose& from, bool is_held) {
  StepState& state = *member.step->state;
  BodyState& body = state.body;
  const HapticModel& model = *member.step->model;
  TakeVelocity(*model.inertia(), from, state.X_WG, member.step->period, body);
  const double reach = model.tool_body()->mesh.reach();
  const double turned = RotationLog(state.X_WG.q * from.q.conjugate()).norm();
  const double way = body.v.norm() * member.step->period + reach * turned;
  is_held |= model.inertia()->body.joint.kind != BodyJoint::Kind::kFree;
  body.still = is_held && way <= limits::body::kStill * member.step->period ? body.still + 1 : 0;
}

/// Puts the bodies of an island without a hand to sleep, once all have been still for long, or are
/// lost.
void Sleep(std::span<Member* const> island) {
  const auto may_sleep = [](const Member* member) {
    if (!IsBody(*member)) return false;
    const StepState& state = *member->step->state;
    const Vec3 placed = member->step->model->reference();
    return state.body.still >= limits::body::kStillSteps ||
           (state.X_WG * placed - placed).norm() > limits::body::kLost;
  };
  if (!std::ranges::all_of(island, may_sleep)) return;
  for (Member* member : island) {
    BodyState& body = member->step->state->body;
    body = {.joint = body.joint, .sleeps = true};
  }
}

/// Steps those of one island as one problem.
void StepIsland(Members members, std::size_t island, Together& together) {
  std::array<std::optional<StepContext>, kMostMembers> contexts;
  std::array<StepContext*, kMostMembers> party;
  std::array<Member*, kMostMembers> member_of;
  std::array<bool, kMostMembers> is_usable;
  std::array<Pose, kMostMembers> from;
  std::size_t count = 0;
  together.place.fill(-1);
  for (std::size_t i = 0; i < members.size(); ++i) {
    if (members[i].island != island || !members[i].is_there) continue;
    together.place[i] = static_cast<std::int32_t>(count);
    member_of[count++] = &members[i];
  }
  if (count == 0 || !member_of[0]->is_awake) return;  // all of an island sleep, or none
  const auto stiffness = [](const ToolStep& step) {
    const Inertia* inertia = step.model->inertia();
    if (inertia != nullptr) return inertia->body.mass / (step.period * step.period);
    return step.share * step.model->parameters().stiffness;
  };
  for (std::size_t i = 0; i < count; ++i) {
    ToolStep& step = *member_of[i]->step;
    const bool is_body = IsBody(*member_of[i]);
    from[i] = step.state->X_WG;
    std::construct_at(&step.report);
    step.report.parameters = &step.model->parameters();
    contexts[i].emplace(*step.model, *step.state, step.workspace->buffers(), step.report);
    party[i] = &*contexts[i];
    party[i]->together = count > 1 || is_body ? &together : nullptr;
    party[i]->weight = stiffness(step) / stiffness(*member_of[0]->step);
    party[i]->period = step.period;
    is_usable[i] = Begin(step.X_WH, *party[i]);
    if (!is_usable[i]) Begin(step.state->X_WH, *party[i]);
  }
  Step(Party(party.data(), count));
  for (std::size_t i = 0; i < count; ++i) {
    StepReport& report = member_of[i]->step->report;
    if (!is_usable[i]) {
      ForgetForces(report);
      report.faults |= kFaultBadPose;
    }
    for (int k = 0; k < report.contacts; ++k) {
      std::int32_t& tool = report.active[static_cast<std::size_t>(k)].tool;
      if (tool >= 0) {
        tool = static_cast<std::int32_t>(member_of[std::size_t(tool)] - members.data());
      }
    }
    if (IsBody(*member_of[i])) EndBody(*member_of[i], from[i], party[i]->outcome.held);
  }
  Sleep(std::span(member_of.data(), count));
}

/// StepTogether, under default rounding.
[[gnu::noinline]] void StepAll(std::span<ToolStep> steps, Together& together) noexcept {
  std::array<Member, kMostMembers> all;
  const Members members(all.data(), steps.size());
  for (std::size_t i = 0; i < steps.size(); ++i) members[i] = MemberOf(steps[i]);
  MakeIslands(members);
  PlaceMembers(members);
  for (std::size_t i = 0; i < steps.size(); ++i) StepIsland(members, i, together);
  PlaceMembers(members);
}

}  // namespace

StepReport HapticStep(const HapticModel& model, const Pose& X_WH, StepState& state,
                      StepWorkspace& workspace, StageTimes* times) noexcept {
  const DefaultRounding rounding;
  return StepAlone(model, X_WH, state, workspace, times);
}

TogetherWorkspace::TogetherWorkspace(std::span<const HapticModel* const> models) {
  const auto require = [](bool holds, const char* what) {
    if (!holds) throw Error(std::string("tools that are stepped together: ") + what);
  };
  require(models.size() >= 2 && models.size() <= kMostMembers, "there must be two to eight");
  int rows = 0;
  for (std::size_t i = 0; i < models.size(); ++i) {
    const HapticModel& model = *models[i];
    require(model.tool_body() != nullptr, "all must touch by their meshes; use \"surface\"");
    require(!model.yields() && !model.cuts(), "nothing may be soft, or cut");
    const auto is_script = [](const MovedGroup& group) { return !group.free; };
    require(std::ranges::none_of(model.moved(), is_script) && model.effects().empty(),
            "no group may move by itself, and there may be no effects: these count steps");
    const FrictionModel friction = model.parameters().features.friction;
    require(friction == models[0]->parameters().features.friction &&
                friction != FrictionModel::kChapter,
            "all must have the same friction, coulomb or none");
    for (const ContactBody& body : model.bodies()) {
      if (body.tool < 0) continue;
      const auto j = static_cast<std::size_t>(body.tool);
      require(body.frame > 0 && j < models.size() && j != i,
              "an object that is a tool must have a frame of its own and another tool's number");
      require(!models[j]->is_ball(), "a ball may be the first of a pair, and not the second");
    }
    rows += model.parameters().max_rows;
  }
  buffers_ = std::make_unique<Together>(rows, models.size());
}
TogetherWorkspace::~TogetherWorkspace() = default;

void StepTogether(std::span<ToolStep> tools, TogetherWorkspace& workspace) noexcept {
  const DefaultRounding rounding;
  StepAll(tools, workspace.buffers());
}

}  // namespace palpate
