#include "server/physics/haptic_step.h"

#include <algorithm>
#include <cmath>

#include "common/math/rotation.h"
#include "server/physics/rows/contact_prediction.h"
#include "server/physics/rows/contact_rows.h"
#include "server/physics/rows/soft_rows.h"
#include "server/physics/solve/contact_wear.h"
#include "server/physics/solve/friction.h"
#include "server/physics/solve/qp_solver.h"
#include "server/physics/solve/response.h"
#include "server/physics/stage_clock.h"
#include "server/physics/step_buffers.h"

namespace palpate {

StepWorkspace::StepWorkspace(const HapticModel& model)
    : buffers_(std::make_unique<Buffers>(model)) {}
StepWorkspace::~StepWorkspace() = default;
StepWorkspace::StepWorkspace(StepWorkspace&&) noexcept = default;

namespace {

bool IsFinite(const Pose& X) {
  return std::isfinite(X.p.x() + X.p.y() + X.p.z()) && std::isfinite(X.q.squaredNorm());
}

/// The step in x = [v; rho phi] that the QP gives, unpacked.
struct Optimum {
  Vec3 v;
  Vec3 phi;
  QpResult qp;
  bool rubs = false;
  FrictionForces friction;  ///< where it rubs: of the QP's active rows
};

/// Nearest step to the target that respects the rows; where `soft` is given, soft rows yield as
/// their stiffness says.  With 3 degrees of freedom the rotation is the hand's: no contact can turn
/// a sphere about its centre.
Optimum Solve(const HapticModel& model, const Kernels& kernels, const Target& target,
              const ContactRows& rows, const QpRows& rigid, SoftRows* soft,
              const StepState& state) {
  Optimum optimum;
  const double rho = model.rotation_length();
  int guess[kMaxActiveRows];
  const int guesses = rows.Find(state.active_pairs.data(), state.active, guess);
  const double t[6] = {target.v.x(),         target.v.y(),         target.v.z(),
                       rho * target.phi.x(), rho * target.phi.y(), rho * target.phi.z()};
  const auto solve = [&]<int N>() {
    return soft != nullptr ? SolveCompliant<N>(kernels, t, soft->view(rows), guess, guesses)
                           : SolveNearestPoint<N>(kernels, t, rigid, guess, guesses);
  };
  if (model.degrees_of_freedom() == 6) {
    optimum.qp = solve.operator()<6>();
    const double* x = optimum.qp.x;
    optimum.phi = Vec3(x[3], x[4], x[5]) / rho;
  } else {
    optimum.qp = solve.operator()<3>();
    optimum.phi = target.phi;
  }
  optimum.v = Vec3(optimum.qp.x[0], optimum.qp.x[1], optimum.qp.x[2]);
  return optimum;
}

/// The same with friction, where the model has it and a row is active.
void AddFriction(const HapticModel& model, const Kernels& kernels, const Mat3& R_WG,
                 const Target& target, const ContactRows& rows, const QpRows& rigid,
                 const SoftContacts& yielding, StepState& state, Optimum& optimum,
                 StepReport& report) {
  if (model.parameters().features.friction != FrictionModel::kCoulomb) return;
  if (optimum.qp.active == 0) return ForgetFriction(state.friction);
  if (state.friction.suspended || optimum.qp.status == QpStatus::kIterationLimit) return;
  optimum.rubs = true;
  // The push of soft contacts counts as it is without friction.
  const double rho = model.rotation_length();
  const Target pushed{target.v + yielding.force, target.phi + yielding.torque / (rho * rho)};
  AddCoulombFriction(model, kernels, R_WG, pushed, rows, rigid, report.substeps == 0,
                     state.friction, optimum.qp, optimum.friction, report);
  const double* x = optimum.qp.x;
  optimum.v = Vec3(x[0], x[1], x[2]);
  if (model.degrees_of_freedom() == 6) {
    optimum.phi = Vec3(x[3], x[4], x[5]) / rho;
  }
}

/// Widest bounds of a sub-step.  Rows between surfaces cost more than those between spheres: near a
/// surface a sub-step takes any point of the tool no further than kNearSurface by translation, and
/// as far by rotation; eight of them still follow a hand at 0.8 m/s.
StepBounds WidestBounds(const HapticModel& model, bool near) {
  constexpr double kNearSurface = 0.1e-3;
  const StepParameters& parameters = model.parameters();
  if (!near || model.tool_surface() == nullptr) {
    return {parameters.max_translation, parameters.max_rotation};
  }
  const double lever = std::max(model.tool().max_lever(), 1e-6);
  return {std::min(parameters.max_translation, kNearSurface),
          std::min(parameters.max_rotation, kNearSurface / lever)};
}

/// Bounds of a cycle's first sub-step: twice what the hand moved, and a little.  A step nearest
/// to the hand's moves no further than the hand does while the same contacts hold; where it does (a
/// ledge ends, a jump), the sub-steps after it have wider bounds.  Tight bounds mean few rows.
StepBounds FirstBounds(const HapticModel& model, const Target& hand_step, bool near) {
  const StepBounds widest = WidestBounds(model, near);
  const StepParameters& parameters = model.parameters();
  const bool surface = model.tool_surface() != nullptr;
  const double of_hand = surface ? 1.4 : 2.0, of_most = surface ? 0.02 : 0.04;
  const double rho = model.rotation_length();
  const double v = hand_step.v.norm(), phi = hand_step.phi.norm();
  return {std::min(of_hand * (v + 0.5 * rho * phi) + of_most * parameters.max_translation,
                   widest.translation),
          std::min(of_hand * (phi + 0.5 * v / rho) + of_most * parameters.max_rotation,
                   widest.rotation)};
}

/// Bounds of the next sub-step: eight times wider; near surfaces no wider than the step wants.
StepBounds Wider(const HapticModel& model, const StepBounds& bounds, const Optimum& wanted,
                 bool near) {
  const StepBounds widest = WidestBounds(model, near);
  double translation = 8.0 * bounds.translation, rotation = 8.0 * bounds.rotation;
  if (model.tool_surface() != nullptr) {
    translation = std::min(translation, std::max(1.25 * wanted.v.norm(), 2.0 * bounds.translation));
    rotation = std::min(rotation, std::max(1.25 * wanted.phi.norm(), 2.0 * bounds.rotation));
  }
  return {std::min(translation, widest.translation), std::min(rotation, widest.rotation)};
}

/// Greatest part, at most 1, of a step that stays inside the bounds that the prediction covers.
/// With 3 degrees of freedom a rotation moves no sphere and needs no bound.
double PartWithin(const StepBounds& bounds, int degrees_of_freedom, const Vec3& v,
                  const Vec3& phi) {
  const double length = v.norm(), angle = phi.norm();
  double part = 1.0;
  if (length > bounds.translation) part = bounds.translation / length;
  if (degrees_of_freedom == 6 && angle * part > bounds.rotation) part = bounds.rotation / angle;
  return part;
}

/// A step that falls short of the optimum aims at this share of the bounds: what is left is for
/// rows that the last rotation's truncation error left violated.  Those must be made good in full,
/// or the errors of many short steps would add up; so the short step is a QP of its own, not a
/// scaled one.
constexpr double kBoundShare = 0.98;

/// The contacts as seen from where the sub-step [v; phi] has taken the tool, (p_W, q_WG): what
/// their rows still allow from there, and where they touch it.
void ReportContacts(const HapticModel& model, const ContactRows& rows, const QpRows& rigid,
                    const Optimum& optimum, const SoftRows* soft, const SoftContacts& yielding,
                    const Vec3& v, const Vec3& phi, const Vec3& p_W, const Quat& q_WG,
                    StepReport& report) {
  const double k_t = model.parameters().stiffness;
  const QpResult& qp = optimum.qp;
  const Mat3 R_WG = q_WG.toRotationMatrix();
  report.contacts = 0;
  report.soft_contacts = yielding.count;
  report.soft_wrench = {k_t * yielding.force, k_t * yielding.torque};
  const auto add = [&](int i, double offset, double force) {
    ActiveRow& row = report.active[static_cast<std::size_t>(report.contacts++)];
    row = ActiveRow{};
    row.pair = rows.pair(i);
    row.normal = rows.normal(i);
    row.lever_cross_normal = rows.lever_cross_normal(i);
    row.offset = offset - row.normal.dot(v) - row.lever_cross_normal.dot(phi);
    row.force = force;
    const ContactPlace place = PlaceOf(model, rows, i, R_WG);
    row.contact_W =
        p_W + (KindOf(row.pair) == RowKind::kLeaves ? place.lever : RotationExp(phi) * place.lever);
    row.object_leaf = place.object_leaf;
    return &row;
  };
  for (int k = 0; k < qp.active; ++k) {
    ActiveRow* row = add(qp.row[k], rigid.b[qp.row[k]], k_t * qp.multiplier[k]);
    if (optimum.rubs) row->friction = k_t * optimum.friction[static_cast<std::size_t>(k)];
  }
  for (int k = 0; k < yielding.listed && report.contacts < kMaxActiveRows; ++k) {
    const int i = yielding.row[k];
    add(i, -rows.gap(i), k_t * yielding.push[k])->stiffness = k_t * soft->weight(i);
  }
}

}  // namespace

StepReport HapticStep(const HapticModel& model, const Pose& X_WH, StepState& state,
                      StepWorkspace& workspace, StageTimes* times) noexcept {
  StepReport report;
  report.X_WG = state.X_WG;
  const double norm2 = X_WH.q.squaredNorm();
  if (!IsFinite(X_WH) || !(norm2 > 1e-12)) {
    report.faults = kFaultBadPose;
    return report;
  }
  StepBuffers& buffers = workspace.buffers();
  ContactRows& rows = buffers.rows;
  const Kernels& kernels = ActiveKernels();
  const StepParameters& parameters = model.parameters();
  const Vec3& reference = model.tool().reference();
  const Quat q_H(X_WH.q.coeffs() / std::sqrt(norm2));
  const Vec3 p_H = X_WH.p + q_H * reference;
  Quat q_G = state.X_WG.q;
  Vec3 p_G = state.X_WG.p + q_G * reference;

  StepBounds bounds = FirstBounds(model, TargetOf(state.X_WH * reference, state.X_WH.q, p_H, q_H),
                                  state.active > 0);
  if (model.tool_surface() != nullptr) {
    bounds.translation = std::max(bounds.translation, state.behind.translation);
    bounds.rotation = std::max(bounds.rotation, state.behind.rotation);
  }
  state.X_WH = {X_WH.p, q_H};
  bool arrived = false;
  std::int64_t spent = 0, last = 0;  // the next sub-step is taken to cost what the last one did
  for (; report.substeps < parameters.max_substeps && !arrived &&
         spent + last <= parameters.max_tested && (report.faults & kFaultUnsolved) == 0;
       ++report.substeps) {
    const std::int64_t before = buffers.prediction.tested();
    const Target target = TargetOf(p_G, q_G, p_H, q_H);
    const Mat3 R_WG = q_G.toRotationMatrix();
    buffers.prediction.Predict(model, kernels, R_WG, p_G, bounds, state.wear, rows, times);
    last = buffers.prediction.tested() - before;
    spent += last;
    StageClock clock(times);
    report.predicted_pairs = rows.count();
    if (rows.overflowed()) report.faults |= kFaultRowsFull;

    // Soft rows first yield; `rigid` is what no step may violate.
    SoftRows* soft = nullptr;
    QpRows rigid = rows.view();
    if (buffers.soft) {
      buffers.soft->Set(*model.soft_leaves(), rows);
      if (buffers.soft->any()) {
        soft = &*buffers.soft;
        rigid = soft->rigid(rows);
      }
    }
    Optimum optimum = Solve(model, kernels, target, rows, rigid, soft, state);
    SoftContacts yielding;
    if (soft != nullptr) yielding = soft->Contacts(rows);
    report.qp_iterations += optimum.qp.iterations;
    AddFriction(model, kernels, R_WG, target, rows, rigid, yielding, state, optimum, report);
    clock.Lap(&StageTimes::solve);

    if (optimum.qp.status == QpStatus::kIterationLimit) {
      report.faults |= kFaultUnsolved;
      report.wrench = SpringWrench(target, Vec3::Zero(), Vec3::Zero(), parameters.stiffness,
                                   parameters.torsional_stiffness);
      break;
    }
    if (optimum.qp.status == QpStatus::kRelaxed) report.faults |= kFaultJammed;
    state.active = optimum.qp.active;
    for (int i = 0; i < state.active; ++i) {
      state.active_pairs[static_cast<std::size_t>(i)] = rows.pair(optimum.qp.row[i]);
    }

    const double part = PartWithin(bounds, model.degrees_of_freedom(), optimum.v, optimum.phi);
    arrived = part == 1.0;

    const bool held = optimum.qp.active != 0 || yielding.count != 0;
    if (!held) {
      // Nothing holds the tool: no force, and it is where the hand is once it can get there.
      report.wrench = Wrench{};
      if (arrived) {
        p_G = p_H;
        q_G = q_H;
      }
    } else {
      // The spring's wrench at the optimum.  Where the sub-step falls short of it the graphic tool
      // is still on its way, and its distance from the hand is no contact: that part gives no
      // force.
      report.wrench = SpringWrench(target, optimum.v, optimum.phi, parameters.stiffness,
                                   parameters.torsional_stiffness);
      if (model.degrees_of_freedom() == 3) report.wrench.torque.setZero();
    }
    Vec3 v = optimum.v, phi = optimum.phi;
    if (held || !arrived) {
      if (!arrived) {
        const Target nearer{kBoundShare * part * v, kBoundShare * part * phi};
        // The way to where the soft rows balance the spring: they have no part in it.
        const Optimum partial = Solve(model, kernels, nearer, rows, rigid, nullptr, state);
        report.qp_iterations += partial.qp.iterations;
        if (partial.qp.status == QpStatus::kIterationLimit) report.faults |= kFaultUnsolved;
        const double clip =
            partial.qp.status == QpStatus::kIterationLimit
                ? 0.0
                : PartWithin(bounds, model.degrees_of_freedom(), partial.v, partial.phi);
        v = clip * partial.v;
        phi = clip * partial.phi;
      }
      report.truncation =
          std::max(report.truncation, 0.5 * phi.squaredNorm() * model.tool().max_lever());
      p_G += v;
      q_G = (RotationExp(phi) * q_G).normalized();
    }
    ReportContacts(model, rows, rigid, optimum, soft, yielding, v, phi, p_G, q_G, report);
    bounds = Wider(model, bounds, optimum, rows.count() > 0);
    clock.Lap(&StageTimes::response);
  }
  if (!arrived && (report.faults & kFaultUnsolved) == 0) report.faults |= kFaultTargetFar;
  state.behind = arrived ? StepBounds{0.0, 0.0} : bounds;

  if (arrived && report.contacts == 0) {
    state.X_WG = {X_WH.p, q_H};
  } else {
    state.X_WG = {p_G - q_G * reference, q_G};
  }
  const Pose X_before = report.X_WG;
  if (parameters.features.friction == FrictionModel::kChapter && arrived &&
      !state.friction.suspended) {
    AddChapterFriction(model, X_before, state, report);
  }
  report.X_WG = state.X_WG;
  if (arrived && parameters.features.removal) WearContacts(model, X_before, state.wear, report);
  return report;
}

}  // namespace palpate
