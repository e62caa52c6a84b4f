#pragma once

#include <array>
#include <optional>

#include "common/math/pose.h"
#include "common/qp/nearest_point.h"
#include "server/physics/contact/mesh_contact.h"
#include "server/physics/haptic_model.h"
#include "server/physics/rows/contact_prediction.h"
#include "server/physics/rows/contact_rows.h"
#include "server/physics/simd/kernels.h"
#include "server/physics/solve/energies.h"
#include "server/physics/solve/response.h"
#include "server/physics/step_state.h"
#include "server/physics/step_types.h"

namespace palpate {

/// Friction forces on the tool, one for each active row of a QpResult, perpendicular to its normal,
/// in W [m]: times k_t, newtons.
using FrictionForces = std::array<Vec3, kMaxActiveRows>;

/// A step [v; phi] of the tool's reference point, in W, that is nearest to a target under the rows.
struct Optimum {
  Vec3 v;    ///< [m]
  Vec3 phi;  ///< [rad]
  QpResult qp;
  bool rubs = false;                                   ///< friction has moved it
  FrictionForces friction;                             ///< where it rubs: of the QP's active rows
  bool rounds = false;                                 ///< with the curvature of a ball's rows
  bool is_pushed = false;                              ///< by energies
  Vec3 push = Vec3::Zero(), push_turn = Vec3::Zero();  ///< their force and torque [m], [m^2]

  /// Whether anything holds the tool.
  bool IsHeld() const { return qp.active != 0 || is_pushed; }

  /// To be called where a solver has written it: what is no number is no optimum.
  void RefuseNaN() {
    if (!v.allFinite() || !phi.allFinite()) qp.status = QpStatus::kIterationLimit;
  }
};

/// What a sub-step comes to: the motion [v; phi] towards an optimum, as far as that was free.
struct Way {
  Optimum optimum;
  Vec3 v = Vec3::Zero(), phi = Vec3::Zero();  ///< [m], [rad]
  bool arrived = false;                       ///< at the optimum
};

/// How far rows between meshes are trusted in a sub-step (ClearWay).
struct TrustRegion {
  int failures = 0;            ///< trials that were not free, since the sub-step began (anew)
  StepBounds first{0.0, 0.0};  ///< how far the first of them went
  bool begun_anew = false;
};

/// Where the tools are: reference points in W [m], and orientations.
struct Tools {
  Vec3 p_H, p_G;
  Quat q_H, q_G;
  Mat3 R_WG;  ///< of q_G where the sub-step begins
};

/// What a cycle has cost so far, as counts.
struct CycleCost {
  std::int64_t packet_pairs = 0;  ///< between leaves
  std::int64_t last = 0;          ///< of them, those of the last sub-step
  std::int64_t looks = 0;         ///< between meshes
  int cut_looks = 0;              ///< of what was cut (CutAway::looks)
  int last_cut_looks = 0;         ///< of them, those of the last sub-step
};

/// A sub-step, from its first rows to its way.
struct SubStep {
  StepBounds bounds{};            ///< how far it may go
  Target target{};                ///< the hand, from where it begins
  QpRows rigid{};                 ///< what it may not violate
  FrictionState friction_before;  ///< as it found it
  int iterates = 0;               ///< rows between meshes come on violation
  TrustRegion trust{};
};

/// The scratch of a step, allocated once: what a StepWorkspace holds.
struct StepBuffers {
  explicit StepBuffers(const HapticModel& model)
      : prediction(model),
        rows(model.parameters().max_rows, PairQuery::kMaxBatch, model.degrees_of_freedom(),
             model.rotation_length()) {
    if (model.tool_body() != nullptr) {
      meshes.emplace(*model.tool_body(), model.bodies(), model.parameters().max_rows,
                     model.parameters().separation, model.parameters().looks);
    }
    if (model.yields() || model.cuts()) {
      energies.emplace(model);
    }
  }
  ContactPrediction prediction;
  ContactRows rows;
  std::optional<MeshContact> meshes;  ///< where objects are felt by their meshes
  std::optional<Energies> energies;   ///< where any acts beside the coupling
};

/// What the stages of a step share, from the pose that comes in to the report that goes out.  One
/// per step, on its stack; each stage fills what the next ones read, in the order of the fields.
struct StepContext {
  StepContext(const HapticModel& the_model, StepState& the_state, StepBuffers& the_buffers,
              StepReport& the_report)
      : model(the_model), state(the_state), buffers(the_buffers), report(the_report) {}

  /// Whether the model has friction by Coulomb's law.
  bool Rubs() const { return model.parameters().features.friction == FrictionModel::kCoulomb; }
  /// Whether meshes may hold the tool, and nothing that does rubs or yields.
  bool IsRigid() const {
    return buffers.meshes && !(buffers.energies && buffers.energies->acts()) && !Rubs();
  }
  /// The same of a ball.
  bool IsFreeBall() const { return IsRigid() && buffers.meshes->meshes.IsBall(); }
  /// How much nearer to the hand a step ends than it begins: |t|^2 - |x - t|^2, with x = [v; rho
  /// phi] and t the hand's [m^2].
  double Gain(const Vec3& step_v, const Vec3& step_phi) const {
    double length2 = step_v.squaredNorm(), along = step_v.dot(sub_step.target.v);
    if (model.degrees_of_freedom() == 6) {
      const double rho2 = model.rotation_length() * model.rotation_length();
      length2 += rho2 * step_phi.squaredNorm();
      along += rho2 * step_phi.dot(sub_step.target.phi);
    }
    return 2.0 * along - length2;
  }
  /// Where the hand is from where the tool is.
  void Aim() {
    sub_step.target = TargetFrom(tools.p_G, tools.q_G, tools.p_H, tools.q_H, state.turn_G);
  }
  /// Of the spring once the tool has made a step towards the target.
  Wrench WrenchAfter(const Vec3& step_v, const Vec3& step_phi) const {
    const StepParameters& spring = model.parameters();
    Wrench wrench = SpringWrench(sub_step.target, step_v, step_phi, spring.stiffness,
                                 spring.torsional_stiffness);
    if (model.degrees_of_freedom() == 3) wrench.torque.setZero();
    return wrench;
  }
  /// The step ends unsolved where such an optimum is none.
  void Require(const Optimum& found) const {
    if (found.qp.status == QpStatus::kIterationLimit) report.faults |= kFaultUnsolved;
  }
  bool IsUnsolved() const { return (report.faults & kFaultUnsolved) != 0; }

  const HapticModel& model;
  const Kernels& kernels = ActiveKernels();
  StepState& state;
  StepBuffers& buffers;
  StepReport& report;
  StageTimes* times = nullptr;  ///< null where nobody times the stages
  Tools tools;
  CycleCost cost;
  SubStep sub_step;
  int stuck_at = -2;     ///< the last sub-step that found no way past what holds the tool
  bool arrived = false;  ///< of the last sub-step's way
  bool held = false;     ///< something kept the tool from the hand there
};

}  // namespace palpate
