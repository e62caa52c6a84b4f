#include "server/physics/haptic_step.h"

#include <algorithm>
#include <cmath>

#include "common/math/rotation.h"
#include "server/physics/limits.h"
#include "server/physics/rows/step_buffers.h"
#include "server/physics/solve/chapter_friction.h"
#include "server/physics/solve/contact_report.h"
#include "server/physics/solve/contact_wear.h"
#include "server/physics/solve/coulomb_friction.h"
#include "server/physics/solve/nearest_step.h"
#include "server/physics/solve/response.h"
#include "server/physics/solve/step_bounds.h"
#include "server/physics/solve/step_context.h"
#include "server/physics/stage_clock.h"

namespace palpate {

StepWorkspace::StepWorkspace(const HapticModel& model)
    : buffers_(std::make_unique<StepBuffers>(model)) {}
StepWorkspace::~StepWorkspace() = default;
StepWorkspace::StepWorkspace(StepWorkspace&&) noexcept = default;

namespace {

bool Begin(const Pose& X_WH, StepContext& context);
bool GoesOn(const StepContext& context);
void Predict(StepContext& context);
void Solve(StepContext& context);
void Rub(StepContext& context);
void Move(StepContext& context);
void Report(StepContext& context);
void GiveUp(StepContext& context);
void End(const Pose& X_WH, StepContext& context);

}  // namespace

StepReport HapticStep(const HapticModel& model, const Pose& X_WH, StepState& state,
                      StepWorkspace& workspace, StageTimes* times) noexcept {
  StepReport report;
  StepContext context(model, state, workspace.buffers(), report);
  context.times = times;
  if (!Begin(X_WH, context)) return report;
  for (; GoesOn(context); ++report.substeps) {
    Predict(context);
    StageClock clock(times);
    Solve(context);
    Rub(context);
    clock.Lap(&StageTimes::solve);
    if (context.optimum.qp.status == QpStatus::kIterationLimit) {
      GiveUp(context);
      break;
    }
    Move(context);
    Report(context);
    clock.Lap(&StageTimes::response);
  }
  End(X_WH, context);
  return report;
}

namespace {

/// Where the tools are, and the first bounds.  False where the pose that came is none: the tool
/// stays.
bool Begin(const Pose& X_WH, StepContext& context) {
  StepState& state = context.state;
  context.report.X_WG = state.X_WG;
  const double norm2 = X_WH.q.squaredNorm();
  if (!std::isfinite(X_WH.p.x() + X_WH.p.y() + X_WH.p.z()) || !std::isfinite(norm2) ||
      !(norm2 > limits::kLeastSquaredNorm)) {
    context.report.faults = kFaultBadPose;
    return false;
  }
  const Vec3& reference = context.model.reference();
  context.q_H = Quat(X_WH.q.coeffs() / std::sqrt(norm2));
  context.p_H = X_WH.p + context.q_H * reference;
  context.q_G = state.X_WG.q;
  context.p_G = state.X_WG.p + context.q_G * reference;
  const Target hand_step = TargetOf(state.X_WH * reference, state.X_WH.q, context.p_H, context.q_H);
  context.bounds = FirstBounds(context.model, hand_step, state.active > 0);
  if (context.model.tool_surface() != nullptr) {
    context.bounds.translation = std::max(context.bounds.translation, state.behind.translation);
    context.bounds.rotation = std::max(context.bounds.rotation, state.behind.rotation);
  }
  state.X_WH = {X_WH.p, context.q_H};
  return true;
}

/// A further sub-step is taken to cost what the last one did.
bool GoesOn(const StepContext& context) {
  const StepParameters& parameters = context.model.parameters();
  return context.report.substeps < parameters.max_substeps && !context.arrived &&
         context.spent + context.last <= parameters.max_tested &&
         (context.report.faults & kFaultUnsolved) == 0;
}

/// The rows that the sub-step has to respect: rigid ones, and those that first yield.
void Predict(StepContext& context) {
  StepBuffers& buffers = context.buffers;
  const std::int64_t before = buffers.prediction.tested();
  context.target = TargetOf(context.p_G, context.q_G, context.p_H, context.q_H);
  context.R_WG = context.q_G.toRotationMatrix();
  buffers.prediction.Predict(context.model, context.kernels, context.R_WG, context.p_G,
                             context.bounds, context.state.wear, buffers.rows, context.times);
  context.last = buffers.prediction.tested() - before;
  context.spent += context.last;
  context.report.predicted_pairs = buffers.rows.count();
  if (buffers.rows.overflowed()) context.report.faults |= kFaultRowsFull;
}

/// The pose nearest to the hand's that the rows allow.
void Solve(StepContext& context) {
  StepBuffers& buffers = context.buffers;
  context.soft = nullptr;
  context.rigid = buffers.rows.view();
  if (buffers.soft) {
    buffers.soft->Set(*context.model.soft_leaves(), buffers.rows);
    if (buffers.soft->any()) {
      context.soft = &*buffers.soft;
      context.rigid = context.soft->rigid(buffers.rows);
    }
  }
  context.optimum = NearestStep(context, context.target, context.soft);
  context.yielding =
      context.soft != nullptr ? context.soft->Contacts(buffers.rows) : SoftContacts{};
  context.report.qp_iterations += context.optimum.qp.iterations;
}

/// The same with friction, where the model has it and a row is active.
void Rub(StepContext& context) {
  FrictionState& friction = context.state.friction;
  if (context.model.parameters().features.friction != FrictionModel::kCoulomb) return;
  if (context.optimum.qp.active == 0) return friction.Forget();
  if (friction.suspended || context.optimum.qp.status == QpStatus::kIterationLimit) return;
  AddCoulombFriction(context);
}

/// Whether anything holds the tool.
bool IsHeld(const StepContext& context) {
  return context.optimum.qp.active != 0 || context.yielding.count != 0;
}

/// The part of the way to the optimum that the bounds allow: the step under the same rows that is
/// nearest to a nearer target.  A step that were only scaled down would make good only a part of
/// what the last rotation left violated, and the errors of many short steps would add up.
void ShortenWay(StepContext& context, double part) {
  const int degrees_of_freedom = context.model.degrees_of_freedom();
  const Target nearer{limits::kBoundShare * part * context.v,
                      limits::kBoundShare * part * context.phi};
  // The way to where the soft rows balance the spring: they have no part in it.
  const Optimum partial = NearestStep(context, nearer, nullptr);
  context.report.qp_iterations += partial.qp.iterations;
  const bool unsolved = partial.qp.status == QpStatus::kIterationLimit;
  if (unsolved) context.report.faults |= kFaultUnsolved;
  const double clip =
      unsolved ? 0.0 : PartWithin(context.bounds, degrees_of_freedom, partial.v, partial.phi);
  context.v = clip * partial.v;
  context.phi = clip * partial.phi;
}

/// Takes the tool to the optimum, or towards it as far as the bounds go.
void Move(StepContext& context) {
  const Optimum& optimum = context.optimum;
  context.state.active = optimum.qp.active;
  for (int i = 0; i < optimum.qp.active; ++i) {
    context.state.active_pairs[static_cast<std::size_t>(i)] =
        context.buffers.rows.pair(optimum.qp.row[i]);
  }
  context.v = optimum.v;
  context.phi = optimum.phi;
  const double part =
      PartWithin(context.bounds, context.model.degrees_of_freedom(), optimum.v, optimum.phi);
  context.arrived = part == 1.0;
  if (context.arrived && !IsHeld(context)) {
    context.p_G = context.p_H;
    context.q_G = context.q_H;
    return;
  }
  if (!context.arrived) ShortenWay(context, part);
  context.report.truncation =
      std::max(context.report.truncation,
               0.5 * context.phi.squaredNorm() * context.model.tool().max_lever());
  context.p_G += context.v;
  context.q_G = (RotationExp(context.phi) * context.q_G).normalized();
}

/// The wrench of the spring at the optimum, and the contacts.  Where the sub-step falls short of it
/// the graphic tool is still on its way, and its distance from the hand is no contact: that part
/// gives no force.  Then the bounds of the next sub-step.
void Report(StepContext& context) {
  const HapticModel& model = context.model;
  const Optimum& optimum = context.optimum;
  StepReport& report = context.report;
  if (optimum.qp.status == QpStatus::kRelaxed) report.faults |= kFaultJammed;
  report.wrench = Wrench{};
  if (IsHeld(context)) {
    report.wrench =
        SpringWrench(context.target, optimum.v, optimum.phi, model.parameters().stiffness,
                     model.parameters().torsional_stiffness);
    if (model.degrees_of_freedom() == 3) report.wrench.torque.setZero();
  }
  ReportContacts(context);
  context.bounds =
      WiderBounds(model, context.bounds, optimum.v, optimum.phi, context.buffers.rows.count() > 0);
}

/// The QP did not end: the tool stays where it is, and the spring pulls.
void GiveUp(StepContext& context) {
  const StepParameters& parameters = context.model.parameters();
  context.report.faults |= kFaultUnsolved;
  context.report.wrench = SpringWrench(context.target, Vec3::Zero(), Vec3::Zero(),
                                       parameters.stiffness, parameters.torsional_stiffness);
}

/// What the next step starts from, and what friction by the chapter's rule and wear make of this
/// one.
void End(const Pose& X_WH, StepContext& context) {
  const Features& features = context.model.parameters().features;
  StepState& state = context.state;
  StepReport& report = context.report;
  if (!context.arrived && (report.faults & kFaultUnsolved) == 0) report.faults |= kFaultTargetFar;
  state.behind = context.arrived ? StepBounds{0.0, 0.0} : context.bounds;
  if (context.arrived && report.contacts == 0) {
    state.X_WG = {X_WH.p, context.q_H};
  } else {
    state.X_WG = {context.p_G - context.q_G * context.model.reference(), context.q_G};
  }
  const Pose X_before = report.X_WG;
  if (features.friction == FrictionModel::kChapter && context.arrived &&
      !state.friction.suspended) {
    AddChapterFriction(context.model, X_before, state, report);
  }
  report.X_WG = state.X_WG;
  if (context.arrived && features.removal) {
    WearContacts(context.model, X_before, state.wear, report);
  }
}

}  // namespace

}  // namespace palpate
