#include "server/physics/haptic_step.h"

#include <algorithm>
#include <cmath>

#include "common/math/rotation.h"
#include "server/physics/limits.h"
#include "server/physics/rows/step_buffers.h"
#include "server/physics/solve/chapter_friction.h"
#include "server/physics/solve/clear_way.h"
#include "server/physics/solve/contact_report.h"
#include "server/physics/solve/contact_wear.h"
#include "server/physics/solve/coulomb_friction.h"
#include "server/physics/solve/nearest_step.h"
#include "server/physics/solve/response.h"
#include "server/physics/solve/round_creases.h"
#include "server/physics/solve/step_bounds.h"
#include "server/physics/solve/step_context.h"
#include "server/physics/stage_clock.h"

namespace palpate {

StepWorkspace::StepWorkspace(const HapticModel& model)
    : buffers_(std::make_unique<StepBuffers>(model)) {}
StepWorkspace::~StepWorkspace() = default;
StepWorkspace::StepWorkspace(StepWorkspace&&) noexcept = default;

namespace {

bool IsFinite(const StepReport& report);
bool Begin(const Pose& X_WH, StepContext& context);
bool GoesOn(const StepContext& context);
void Predict(StepContext& context);
void Solve(StepContext& context);
void Round(StepContext& context);
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
    for (bool clear = false; !clear && !context.IsUnsolved();) {
      Solve(context);
      Round(context);
      Rub(context);
      context.Require(context.optimum);
      clock.Lap(&StageTimes::solve);
      if (context.IsUnsolved()) break;
      Remember(context);
      clear = ClearWay(context);
      clock.Lap(&StageTimes::rows);
    }
    if (!context.IsUnsolved()) {
      Move(context);
      Report(context);
    }
    if (context.IsUnsolved()) GiveUp(context);
    clock.Lap(&StageTimes::response);
  }
  End(X_WH, context);
  return report;
}

namespace {

bool IsFinite(const StepReport& report) {
  return report.wrench.force.allFinite() && report.wrench.torque.allFinite() &&
         report.X_WG.p.allFinite() && report.X_WG.q.coeffs().allFinite();
}

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
  context.bounds = FirstBounds(context.model, hand_step);
  context.bounds.translation = std::max(context.bounds.translation, state.behind.translation);
  context.bounds.rotation = std::max(context.bounds.rotation, state.behind.rotation);
  state.X_WH = {X_WH.p, context.q_H};
  return true;
}

/// A further sub-step between leaves is taken to cost what the last one did.
bool GoesOn(const StepContext& context) {
  const StepParameters& parameters = context.model.parameters();
  if (limits::mesh::kMaxLooks - context.looks < limits::mesh::kLeastLooks) return false;
  return context.report.substeps < parameters.max_substeps && !context.arrived &&
         context.spent + context.last <= parameters.max_tested && !context.IsUnsolved();
}

/// The rows between leaves that the sub-step has to respect, rigid ones and those that first yield;
/// and the triangles that it could bring together, with the rows of those that touched last.
void Predict(StepContext& context) {
  StepBuffers& buffers = context.buffers;
  const std::int64_t before = buffers.prediction.tested();
  context.friction_before = context.state.friction;
  context.iterates = 0;
  context.trust = {};
  context.Aim();
  context.R_WG = context.q_G.toRotationMatrix();
  buffers.prediction.Predict(context.model, context.kernels, context.R_WG, context.p_G,
                             context.bounds, context.state.wear, buffers.rows, context.times);
  context.last = buffers.prediction.tested() - before;
  context.spent += context.last;
  if (buffers.meshes) {
    StageClock clock(context.times);
    const bool turns = context.model.degrees_of_freedom() == 6;
    buffers.meshes->Begin(context.kernels, context.state.front,
                          {context.p_G, turns ? context.q_G : Quat::Identity()},
                          context.state.active_pairs.data(), context.state.active,
                          limits::mesh::kMaxLooks - context.looks, buffers.rows);
    clock.Lap(&StageTimes::prediction);
  }
  context.report.predicted_pairs = buffers.rows.count();
  if (buffers.rows.overflowed()) context.report.faults |= kFaultRowsFull;
}

/// The pose nearest to the hand's that the rows allow.
void Solve(StepContext& context) {
  StepBuffers& buffers = context.buffers;
  ++context.iterates;
  buffers.rows.Finish();
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
  if (buffers.meshes && !context.soft &&
      (context.optimum.qp.status == QpStatus::kRelaxed ||
       context.Gain(context.optimum.v, context.optimum.phi) < 0.0) &&
      buffers.meshes->GiveUpRegain(buffers.rows)) {
    context.optimum = NearestStep(context, context.target, context.soft);
  }
  context.yielding =
      context.soft != nullptr ? context.soft->Contacts(buffers.rows) : SoftContacts{};
  context.report.qp_iterations += context.optimum.qp.iterations;
}

/// The same for a ball that goes round creases.
void Round(StepContext& context) {
  context.rounds = context.IsFreeBall() && RoundCreases(context);
}

/// The same with friction, where the model has it and a row is active.
void Rub(StepContext& context) {
  FrictionState& friction = context.state.friction;
  if (context.iterates > 1) friction = context.friction_before;
  if (!context.Rubs()) return;
  if (context.optimum.qp.active == 0 || friction.suspended ||
      context.optimum.qp.status == QpStatus::kIterationLimit) {
    return;
  }
  AddCoulombFriction(context);
}

/// Takes the tool there.
void Move(StepContext& context) {
  const bool meshes = context.buffers.meshes.has_value();
  if (!context.IsHeld()) context.state.turn_G.setZero();
  if (meshes) {
    context.buffers.meshes->Accept();
    context.looks += context.buffers.meshes->looks();
  }
  if (context.Rubs() && context.optimum.qp.active == 0 && (context.arrived || !meshes)) {
    context.state.friction.Forget();
  }
  if (context.arrived && !context.IsHeld()) {
    context.p_G = context.p_H;
    context.q_G = context.q_H;
    return;
  }
  context.report.truncation =
      std::max(context.report.truncation,
               0.5 * context.phi.squaredNorm() * context.model.tool().max_lever());
  context.p_G += context.v;
  context.q_G = (RotationExp(context.phi) * context.q_G).normalized();
}

/// Between meshes, where the tool has not arrived, the optimum lies beyond what its rows are known
/// for.  What is known is what the contacts at the tool's place hold back of the spring there: the
/// multipliers of the spring's pull, projected onto the motions that those rows allow.  Where the
/// tool has arrived this is the optimum's own wrench; without a contact it is zero.
void ReportLag(StepContext& context) {
  ContactRows& rows = context.buffers.rows;
  for (int i = 0; i < rows.count(); ++i) {
    const double left = rows.Left(i, context.v, context.phi);
    rows.SetGap(i, left);
    if (left > limits::mesh::kTouching) rows.Loosen(i);
  }
  // The tool's place is free, whatever a row that was made for a trial elsewhere says of it.  So
  // the wrench is never more than the spring's own.
  rows.AdmitZero();
  context.v.setZero();
  context.phi.setZero();
  context.Aim();
  Solve(context);
  context.Require(context.optimum);
  Remember(context);
}

/// The wrench of the spring at the optimum, and the contacts.  Where the sub-step falls short of it
/// the graphic tool is still on its way, and its distance from the hand is no contact: that part
/// gives no force.  Then the bounds of the next sub-step.
void Report(StepContext& context) {
  const HapticModel& model = context.model;
  StepReport& report = context.report;
  if (context.buffers.meshes && !context.arrived) ReportLag(context);
  const Optimum& optimum = context.optimum;
  if (optimum.qp.status == QpStatus::kRelaxed) report.faults |= kFaultJammed;
  report.wrench = context.IsHeld() ? context.WrenchAfter(optimum.v, optimum.phi) : Wrench{};
  ReportContacts(context);
  context.bounds = WiderBounds(model, context.bounds);
}

/// A QP did not end, or not with numbers: the tool stays where it is, and the spring pulls.  What
/// was found on the way belongs to no place, and nothing of it goes on.
void GiveUp(StepContext& context) {
  StepReport& report = context.report;
  context.arrived = false;
  context.state.active = 0;
  context.state.friction = context.friction_before;
  report.contacts = report.soft_contacts = 0;
  report.soft_wrench = Wrench{};
  context.Aim();
  report.wrench = context.WrenchAfter(Vec3::Zero(), Vec3::Zero());
}

/// What the next step starts from, and what friction by the chapter's rule and wear make of this
/// one.
void End(const Pose& X_WH, StepContext& context) {
  const Features& features = context.model.parameters().features;
  StepState& state = context.state;
  StepReport& report = context.report;
  if (!context.arrived && !context.IsUnsolved()) report.faults |= kFaultTargetFar;
  const bool lags = context.buffers.meshes && !context.arrived;
  state.behind = lags ? context.bounds : StepBounds{0.0, 0.0};
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
  // Whatever the numbers that came in: nothing else than numbers goes out.
  if (!IsFinite(report)) {
    state.X_WG = report.X_WG = X_before;
    state.ForgetContact();
    report.wrench = report.soft_wrench = Wrench{};
    report.contacts = report.soft_contacts = 0;
    report.faults |= kFaultUnsolved;
  }
}

}  // namespace

}  // namespace palpate
