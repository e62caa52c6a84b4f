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

bool Begin(const Pose& X_WH, StepContext& context);
bool GoesOn(const StepContext& context);
void Predict(StepContext& context);
void Solve(StepContext& context);
void Round(StepContext& context);
void Rub(StepContext& context);
void Remember(StepContext& context);
bool Clear(StepContext& context);
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
    for (bool clear = false; !clear;) {
      Solve(context);
      Round(context);
      Rub(context);
      Remember(context);
      clock.Lap(&StageTimes::solve);
      if (context.optimum.qp.status == QpStatus::kIterationLimit) {
        GiveUp(context);
        End(X_WH, context);
        return report;
      }
      clear = Clear(context);
      clock.Lap(&StageTimes::rows);
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
  context.bounds = FirstBounds(context.model, hand_step);
  context.bounds.translation = std::max(context.bounds.translation, state.behind.translation);
  context.bounds.rotation = std::max(context.bounds.rotation, state.behind.rotation);
  state.X_WH = {X_WH.p, context.q_H};
  return true;
}

/// A further sub-step is taken to cost what the last one did.
bool GoesOn(const StepContext& context) {
  const StepParameters& parameters = context.model.parameters();
  if (context.looks + context.last_looks > limits::mesh::kMaxLooks) return false;
  return context.report.substeps < parameters.max_substeps && !context.arrived &&
         context.spent + context.last <= parameters.max_tested &&
         (context.report.faults & kFaultUnsolved) == 0;
}

/// The rows between leaves that the sub-step has to respect, rigid ones and those that first yield;
/// and the triangles that it could bring together, with the rows of those that touched last.
void Predict(StepContext& context) {
  StepBuffers& buffers = context.buffers;
  const std::int64_t before = buffers.prediction.tested();
  context.friction_before = context.state.friction;
  context.iterates = 0;
  context.target = TargetOf(context.p_G, context.q_G, context.p_H, context.q_H);
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
                          context.state.active_pairs.data(), context.state.active, buffers.rows);
    clock.Lap(&StageTimes::prediction);
  }
  context.report.predicted_pairs = buffers.rows.count();
  if (buffers.rows.overflowed()) context.report.faults |= kFaultRowsFull;
}

/// Whether a step ends farther from the hand than it begins: |x - t| > |t|, with x = [v; rho phi]
/// and t the hand's.
bool Lifts(const StepContext& context, const Vec3& v, const Vec3& phi) {
  double length2 = v.squaredNorm(), along = v.dot(context.target.v);
  if (context.model.degrees_of_freedom() == 6) {
    const double rho2 = std::pow(context.model.rotation_length(), 2);
    length2 += rho2 * phi.squaredNorm();
    along += rho2 * phi.dot(context.target.phi);
  }
  return along < 0.5 * length2;
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
       Lifts(context, context.optimum.v, context.optimum.phi)) &&
      buffers.meshes->GiveUpRegain(buffers.rows)) {
    context.optimum = NearestStep(context, context.target, context.soft);
  }
  context.yielding =
      context.soft != nullptr ? context.soft->Contacts(buffers.rows) : SoftContacts{};
  context.report.qp_iterations += context.optimum.qp.iterations;
}

bool Rubs(const StepContext& context) {
  return context.model.parameters().features.friction == FrictionModel::kCoulomb;
}

/// Whether the tool is a ball that nothing but a mesh and the spring holds.
bool IsFreeBall(const StepContext& context) {
  return context.buffers.meshes && context.buffers.meshes->tool().radius > 0.0 && !context.soft &&
         !Rubs(context);
}

/// The same for a ball that goes round creases.
void Round(StepContext& context) {
  context.rounds = IsFreeBall(context) && RoundCreases(context);
}

/// The same with friction, where the model has it and a row is active.
void Rub(StepContext& context) {
  FrictionState& friction = context.state.friction;
  if (context.iterates > 1) friction = context.friction_before;
  if (!Rubs(context)) return;
  if (context.optimum.qp.active == 0 || friction.suspended ||
      context.optimum.qp.status == QpStatus::kIterationLimit) {
    return;
  }
  AddCoulombFriction(context);
}

/// The rows that hold the tool: the solver's first guess next time.
void Remember(StepContext& context) {
  context.state.active = context.optimum.qp.active;
  for (int i = 0; i < context.state.active; ++i) {
    context.state.active_pairs[static_cast<std::size_t>(i)] =
        context.buffers.rows.pair(context.optimum.qp.row[i]);
  }
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

/// A way nearer to the hand, where rows that were made for a trial let only such through as lead
/// away from it: under the same rows, lowered to what the tool's own place allows.
/// Without it a tool in a hollow that is sharper than the hand is deep would go beyond the bottom,
/// and back in the next step, and never rest.
void StepDown(StepContext& context) {
  context.buffers.rows.AdmitZero();
  context.optimum = NearestStep(context, context.target, nullptr);
  context.report.qp_iterations += context.optimum.qp.iterations;
  Remember(context);
  const double part = PartWithin(context.bounds, context.model.degrees_of_freedom(),
                                 context.optimum.v, context.optimum.phi);
  context.arrived = part == 1.0;
  context.v = part * context.optimum.v;
  context.phi = part * context.optimum.phi;
}

/// The way to the optimum, as far as the bounds go; and whether the meshes are apart at its end. If
/// not, there are new rows, and it all begins again.  A way that is still not free in the end is
/// halved until it is: the tool's own place always is.
bool Clear(StepContext& context) {
  StepBuffers& buffers = context.buffers;
  const Optimum& optimum = context.optimum;
  context.v = optimum.v;
  context.phi = optimum.phi;
  const double part =
      PartWithin(context.bounds, context.model.degrees_of_freedom(), optimum.v, optimum.phi);
  context.arrived = part == 1.0;
  if (!context.arrived) ShortenWay(context, part);
  if (!buffers.meshes) return true;
  MeshContact& meshes = *buffers.meshes;
  const auto is_free = [&] {
    const bool turns = context.model.degrees_of_freedom() == 6;
    return meshes.Check(context.v, turns ? context.phi : Vec3::Zero(), buffers.rows) == 0;
  };
  const bool goes_on = context.iterates < limits::mesh::kIterates;
  if (is_free()) {
    if (context.arrived && goes_on) {
      if (meshes.Retract(optimum.qp.row, optimum.qp.active, buffers.rows) != 0) return false;
      // A ball's rows have the smooth surface's normals at the trial, so the ball rests there,
      // though the facets on the way may have lifted it.  At a crease they have those of the
      // beginning: the ball has not arrived, and goes on round it.
      if (IsFreeBall(context)) {
        context.arrived =
            meshes.Turned(optimum.qp.row, optimum.qp.active, buffers.rows) <= limits::mesh::kTurned;
      }
      if (meshes.tool().radius > 0.0) return true;
    }
    // What yields pushes as well: the optimum of both may lie farther from the hand.  So may a
    // straight way past a crease, where the arc ends nearer.
    if (!Lifts(context, context.v, context.phi) || Rubs(context) || context.soft || context.rounds)
      return true;
    StepDown(context);
    if (is_free()) return true;
  } else if (goes_on && !meshes.IsExhausted()) {
    return false;
  }
  context.arrived = false;
  context.state.friction = context.friction_before;  // of no trial
  const auto way = [&] {
    return context.v.norm() + meshes.tool().mesh.reach() * context.phi.norm();
  };
  while (!meshes.IsFull() && way() > limits::mesh::kRounding) {
    context.v *= 0.5;
    context.phi *= 0.5;
    if (is_free()) return true;
  }
  context.v.setZero();
  context.phi.setZero();
  meshes.Stay();
  return true;
}

/// Takes the tool there.
void Move(StepContext& context) {
  const bool meshes = context.buffers.meshes.has_value();
  if (meshes) {
    context.buffers.meshes->Accept();
    context.last_looks = context.buffers.meshes->looks();
    context.looks += context.last_looks;
  }
  if (Rubs(context) && context.optimum.qp.active == 0 && (context.arrived || !meshes)) {
    context.state.friction.Forget();
  }
  if (context.arrived && !IsHeld(context)) {
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
  context.target = TargetOf(context.p_G, context.q_G, context.p_H, context.q_H);
  Solve(context);
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
  report.wrench = Wrench{};
  if (IsHeld(context)) {
    report.wrench =
        SpringWrench(context.target, optimum.v, optimum.phi, model.parameters().stiffness,
                     model.parameters().torsional_stiffness);
    if (model.degrees_of_freedom() == 3) report.wrench.torque.setZero();
  }
  ReportContacts(context);
  context.bounds = WiderBounds(model, context.bounds);
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
}

}  // namespace

}  // namespace palpate
