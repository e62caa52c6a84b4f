#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "common/math/pose.h"
#include "common/qp/nearest_point.h"
#include "server/physics/contact/sub_step.h"
#include "server/physics/haptic_model.h"
#include "server/physics/rows/contact_prediction.h"
#include "server/physics/rows/contact_rows.h"
#include "server/physics/simd/aligned_columns.h"
#include "server/physics/simd/kernels.h"
#include "server/physics/solve/energies.h"
#include "server/physics/solve/response.h"
#include "server/physics/step_state.h"
#include "server/physics/step_types.h"

namespace palpate {

/// Friction forces on the tool, one for each active row of a QpResult, perpendicular to its normal,
/// in W [m]; times k_t, newtons.
using FrictionForces = std::array<Vec3, kMaxActiveRows>;

/// The step [v; phi] of the tool's reference point, in W, that is nearest to a
/// target under the rows.
struct Optimum {
  Vec3 v;    ///< [m]
  Vec3 phi;  ///< [rad]
  QpResult qp;
  bool has_friction = false;                                 ///< whether friction has changed it
  bool friction_unsolved = false, friction_yielded = false;  ///< as StepDiagnostics counts them
  FrictionForces friction;  ///< if so: for each active row of the QP
  bool rounds = false;      ///< whether it includes the curvature of a ball's rows
  bool is_pushed = false;   ///< whether energies push
  bool is_touched = false;  ///< whether rows of others, which name this, or its joint's limits act
  Vec3 push = Vec3::Zero(), push_torque = Vec3::Zero();  ///< their force and torque [m], [m^2]

  /// Returns whether anything holds the tool.
  bool IsHeld() const { return qp.active != 0 || is_pushed || is_touched; }

  /// Call after a solver has written `qp`; one that is not a number counts as unsolved.
  void Take(double rotation_length) {
    v = Vec3::Map(qp.x);
    phi = Vec3::Map(qp.x + 3) / rotation_length;
    if (!v.allFinite() || !phi.allFinite()) qp.status = QpStatus::kIterationLimit;
  }
};

/// The result of a sub-step: the motion [v; phi] towards an optimum, as far as it was free.
struct Advance {
  Optimum optimum;
  Vec3 v = Vec3::Zero(), phi = Vec3::Zero();  ///< [m], [rad]
  bool arrived = false;    ///< whether it reaches the optimum, and contacts hold the tool there
  double fraction = 1.0;   ///< of the last candidate, that the meshes allowed
  double of_frames = 1.0;  ///< how much of their part in the sub-step the frames move
};

/// How far rows between meshes are trusted in a sub-step (MakeAdvance).
struct TrustRegion {
  int failures = 0;            ///< candidates that were not free since the sub-step last began
  StepBounds first{0.0, 0.0};  ///< how far the first of them went
  bool shrunk = false;         ///< whether it has been made shorter in this sub-step
};

/// The poses of both tools: reference points in W [m], and orientations.
struct Tools {
  Vec3 p_H, p_G;
  Quat q_H, q_G;
  Mat3 R_WG;  ///< of q_G at the beginning of the sub-step
};

/// The cost of a cycle so far, as counts.
struct CycleCost {
  std::int64_t packet_pairs = 0;  ///< between leaves
  std::int64_t last = 0;          ///< those of the last walk of the trees
  std::int64_t queries = 0;       ///< between meshes
  int cut_queries = 0;            ///< of removing material (CutAway::queries)
  int last_cut_queries = 0;       ///< those of the last sub-step
};

/// A sub-step, from its first rows to its advance.
struct SubStep {
  StepBounds bounds{};         ///< how far it may go
  StepEnds ends{};             ///< where the rows between leaves let it end
  StepBounds bounds_before{};  ///< `bounds` before it looked ahead
  int predictions = 0;         ///< if they are predicted where it ends: how often so far
  Target target{};             ///< the hand, relative to where it begins
  QpRows rigid{};              ///< rows that it may not violate
  int iterates = 0;            ///< rounds so far: rows between meshes are added on violation
  TrustRegion trust{};
  double of_frames = 1.0;  ///< part of what their motion has left that the frames make
  // What StepState takes over if the tool advances.
  ActiveIds active{};  ///< the rows of the last optimum
  bool is_crowded = false;
};

/// How the sub-steps so far have ended.
struct Outcome {
  bool arrived = false;  ///< whether it arrived there
  bool stands = false;   ///< whether the last that no contact held was a short one (Settle)
  bool held = false;     ///< whether something then kept the tool from the hand
};

/// The scratch memory of a step, allocated once: the contents of a StepWorkspace.
struct StepBuffers {
  explicit StepBuffers(const HapticModel& model)
      : prediction(model),
        tool_of_frame(CountFrames(model.bodies()), -1),
        rows(model.parameters().max_rows, model.rotation_length(), !model.is_ball(),
             std::ranges::any_of(model.bodies(),
                                 [](const ContactBody& body) { return body.tool >= 0; })) {
    for (const ContactBody& body : model.bodies()) {
      if (body.tool >= 0) tool_of_frame[static_cast<std::size_t>(body.frame)] = body.tool;
    }
    if (model.tool_body() != nullptr) {
      meshes.emplace(*model.tool_body(), model.bodies(), model.parameters().max_rows,
                     model.parameters().separation, model.parameters().queries);
    }
    energies.emplace(model);
    if (energies->empty()) energies.reset();
  }
  ContactPrediction prediction;
  std::vector<std::int32_t> tool_of_frame;  ///< the tool that a frame is; negative: none
  ContactRows rows;
  std::optional<BodyContact> meshes;  ///< if objects are touched by their meshes
  std::optional<Energies> energies;   ///< if any can act beside the coupling
};

struct Together;

/// The data that the stages of a step share, from the incoming pose to the outgoing
/// report.  Each step has one, on its stack; each stage fills what the next ones read, in
/// the order of the fields.
struct StepContext {
  StepContext(const HapticModel& the_model, StepState& the_state, StepBuffers& the_buffers,
              StepReport& the_report)
      : model(the_model), state_(the_state), buffers_(the_buffers), report_(the_report) {}

  // Of a const context, all of this is const.
  StepState& state() { return state_; }
  const StepState& state() const { return state_; }
  StepBuffers& buffers() { return buffers_; }
  const StepBuffers& buffers() const { return buffers_; }
  StepReport& report() { return report_; }
  const StepReport& report() const { return report_; }

  /// Returns whether the model has friction by Coulomb's law.
  bool HasFriction() const {
    return model.parameters().features.friction == FrictionModel::kCoulomb;
  }
  /// Returns whether meshes may hold the tool and nothing yields.
  bool IsHeldByRows() const {
    return buffers_.meshes && !(buffers_.energies && buffers_.energies->acts());
  }
  /// Returns whether IsHeldByRows holds and no friction acts.
  bool IsRigid() const { return IsHeldByRows() && !HasFriction(); }
  /// Returns whether IsRigid holds and the tool is a ball.
  bool IsFreeBall() const { return IsRigid() && buffers_.meshes->IsBall(); }
  /// Returns how much nearer to the hand a step ends than it begins: |t|^2 - |x - t|^2, with x =
  /// [v; rho phi] and t the hand's [m^2]; of a body by its metric.
  double Gain(const Vec3& step_v, const Vec3& step_phi) const {
    if (metric) {
      const Vec6 y = metric->A * Stacked(step_v, step_phi);
      return y.dot(2.0 * metric->A * Stacked(sub_step.target.v, sub_step.target.phi) - y);
    }
    const double rho2 = model.rotation_length() * model.rotation_length();
    const double length2 = step_v.squaredNorm() + rho2 * step_phi.squaredNorm();
    return 2.0 * (step_v.dot(sub_step.target.v) + rho2 * step_phi.dot(sub_step.target.phi)) -
           length2;
  }
  BodyFrame& FrameOf(const MeshContact& contact) {
    return state_.frames[static_cast<std::size_t>(contact.meshes.frame)];
  }
  /// Returns where the tool is in a frame.
  RelativePose ToolIn(const MeshContact& contact) {
    const Quat q = model.is_ball() ? Quat::Identity() : tools.q_G;
    if (contact.moved.is_W()) return {tools.p_G, q};
    const Pose& X_WB = FrameOf(contact).X_WB;
    return {X_WB.Inverse() * tools.p_G,
            model.is_ball() ? q : Quat((X_WB.q.conjugate() * q).normalized())};
  }
  /// Returns how the body moves that a row touches; null if it is in W, or a tool.
  const FrameMotion* MotionOf(const ContactId& id) const {
    const auto body = static_cast<std::size_t>(id.body);
    if (id.IsOfLeaves() || body >= model.bodies().size()) return nullptr;
    const auto frame = static_cast<std::size_t>(model.bodies()[body].frame);
    if (frame == 0 || buffers_.tool_of_frame[frame] >= 0) return nullptr;
    return &buffers_.meshes->of[frame].moved;
  }
  /// Returns the place in the party of the tool that a frame is; negative: it is none, or away.
  std::int32_t ToolOf(const MeshContact& contact) const;
  /// Returns whether bodies move in this sub-step, other tools apart.
  bool BodiesMove() const {
    const auto moves = [](const MeshContact& contact) {
      return !contact.moved.is_tool() && contact.moved.moves();
    };
    return buffers_.meshes && std::ranges::any_of(buffers_.meshes->of, moves);
  }
  /// Returns [v; rho phi].
  Vec6 Stacked(const Vec3& v, const Vec3& phi) const {
    Vec6 x;
    x << v, model.rotation_length() * phi;
    return x;
  }
  /// Sets the target: the hand relative to the tool; of a body, also its metric.
  void Aim() {
    if (const Inertia* inertia = model.inertia()) {
      metric = MetricAt(*inertia, {tools.p_G - tools.q_G * model.reference(), tools.q_G},
                        state_.body, period, model.rotation_length());
      sub_step.target = TargetOf(tools.p_G, tools.q_G, tools.p_H, tools.q_H);
      return;
    }
    sub_step.target = TargetFrom(tools.p_G, tools.q_G, tools.p_H, tools.q_H, state_.rotation_G);
  }
  /// Returns the spring's wrench after the tool has made a step towards the target.
  Wrench WrenchAfter(const Vec3& step_v, const Vec3& step_phi) const {
    const StepParameters& spring = model.parameters();
    return SpringWrench(sub_step.target, step_v, step_phi, spring.stiffness,
                        spring.torsional_stiffness);
  }
  /// Sets kFaultUnsolved if the solver found no optimum; the step then ends.
  void Require(const Optimum& found) {
    if (found.qp.status == QpStatus::kIterationLimit) report_.faults |= kFaultUnsolved;
  }
  bool IsUnsolved() const { return (report_.faults & kFaultUnsolved) != 0; }

  const HapticModel& model;
  const Kernels& kernels = ActiveKernels();
  StageTimes* times = nullptr;  ///< null if the stages are not timed
  Tools tools;
  CycleCost cost;
  SubStep sub_step;
  FrictionState friction;  ///< with friction: what the state takes over if the tool advances
  Target goal;             ///< of NearestSteps
  Optimum nearest;         ///< its result
  Advance advance;         ///< the candidate
  Outcome outcome;
  // Of a tool that is stepped together with others, and of a body:
  double weight = 1.0;  ///< its k_t over that of the first
  double Scale() const { return std::sqrt(weight); }
  Together* together = nullptr;      ///< null for a tool that is alone
  double period = 0.0;               ///< of a body [s]
  std::optional<BodyMetric> metric;  ///< of a body

  // The unknowns y of a party: a tool's are sqrt(w) x, x = [v; rho phi]; a body's sqrt(w) A (x -
  // c).
  Vec6 ToUnknowns(const Vec3& v, const Vec3& phi) const {
    if (metric) return ToUnknowns(Stacked(v, phi));
    Vec6 y;
    y << Scale() * v, Scale() * model.rotation_length() * phi;
    return y;
  }
  Vec6 ToUnknowns(const Vec6& x) const {
    return Scale() * (metric ? Vec6(metric->A * (x - metric->c)) : x);
  }
  Vec6 FromUnknowns(const Vec6& y) const {
    const Vec6 x = y / Scale();
    return metric ? Vec6(metric->B * x + metric->c) : x;
  }
  /// Returns a row of x as one of y, and what must be taken from its b.
  Vec6 RowOfUnknowns(const Vec6& a) const {
    return (metric ? Vec6(metric->B.transpose() * a) : a) / Scale();
  }
  Vec6 RowOfUnknowns(const Vec3& v, const Vec3& by_rotation) const {
    const double rho = model.rotation_length();
    Vec6 a;
    if (metric) {
      a << v, by_rotation / rho;
      return RowOfUnknowns(a);
    }
    a << v / Scale(), by_rotation / (rho * Scale());
    return a;
  }
  double OffsetOf(const Vec6& a) const { return metric ? a.dot(metric->c) : 0.0; }

 private:
  StepState& state_;
  StepBuffers& buffers_;
  StepReport& report_;
};

/// The tools of a step, by their numbers; nearly always one.  What they share, such as the count of
/// iterates, is kept by the first.
using Party = std::span<StepContext* const>;
inline StepContext& Lead(Party tools) {
  return *tools.front();
}
inline bool AreUnsolved(Party tools) {
  return std::ranges::any_of(tools, &StepContext::IsUnsolved);
}

/// A row of a tool.
struct ToolRow {
  std::size_t tool;
  int row;
  bool operator==(const ToolRow&) const = default;
};

/// The scratch memory of a step of several tools and bodies: their rows side by side.
struct Together {
  /// Most rows of all members, and of the limits of their joints.
  explicit Together(int most_rows, std::size_t members)
      : columns(UnknownsOf(members) + 1, static_cast<std::size_t>(most_rows) + 2 * members + 16) {}
  static std::size_t UnknownsOf(std::size_t members) {
    return members <= 2 ? 12 : members <= 4 ? 24 : 48;
  }
  AlignedColumns columns;
  int rows = 0;
  /// In the party, by a member's number; negative: it is not solved with it.
  std::array<std::int32_t, kMostMembers> place;
};

inline std::int32_t StepContext::ToolOf(const MeshContact& contact) const {
  const std::int32_t tool = buffers_.tool_of_frame[static_cast<std::size_t>(contact.meshes.frame)];
  return tool < 0 || together == nullptr ? -1 : together->place[static_cast<std::size_t>(tool)];
}

}  // namespace palpate
