#include "server/physics/solve/clear_way.h"

#include <algorithm>

#include "server/physics/limits.h"
#include "server/physics/solve/nearest_step.h"
#include "server/physics/solve/step_bounds.h"

namespace palpate {
namespace {

/// Goes some part of the way to the optimum.
void GoTo(StepContext& context, double part) {
  context.v = part * context.optimum.v;
  context.phi = part * context.optimum.phi;
}

/// The part of the way to the optimum that the bounds allow.
double PartWithin(const StepContext& context) {
  return PartWithin(context.bounds, context.model.degrees_of_freedom(), context.optimum.v,
                    context.optimum.phi);
}

/// Goes to the optimum under rows that have changed, as far as the bounds allow.  Where the QP does
/// not end the tool stays, and has not arrived.
void GoToNewOptimum(StepContext& context) {
  context.optimum = NearestStep(context, context.target, nullptr);
  context.report.qp_iterations += context.optimum.qp.iterations;
  Remember(context);
  context.Require(context.optimum);
  const double part = context.IsUnsolved() ? 0.0 : PartWithin(context);
  context.arrived = part == 1.0;
  GoTo(context, part);
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
  context.Require(partial);
  const double clip = context.IsUnsolved()
                          ? 0.0
                          : PartWithin(context.bounds, degrees_of_freedom, partial.v, partial.phi);
  context.v = clip * partial.v;
  context.phi = clip * partial.phi;
}

/// How far a point of the tool's mesh goes at most.
double Way(const StepContext& context) {
  return context.v.norm() + context.buffers.meshes->tool().mesh.reach() * context.phi.norm();
}

/// With 3 degrees of freedom no rotation moves a mesh.
Vec3 TurnOfMesh(const StepContext& context) {
  return context.model.degrees_of_freedom() == 6 ? context.phi : Vec3::Zero();
}

/// Whether the meshes are apart at the motion's end, and were on the way.
bool IsFree(StepContext& context) {
  return context.buffers.meshes->IsFree(context.v, TurnOfMesh(context));
}

/// Of a tool that has arrived: whether rows change because they are not true of that place.
bool Mend(StepContext& context) {
  MeshContact& meshes = *context.buffers.meshes;
  ContactRows& rows = context.buffers.rows;
  const QpResult& qp = context.optimum.qp;
  if (meshes.Retract(qp.row, qp.active, rows) != 0) return true;
  if (context.IsFreeBall()) {
    // A ball's rows have the smooth surface's normals at the trial, so the ball rests there, though
    // the facets on the way may have lifted it.  At a crease they have those of the beginning: the
    // ball has not arrived, and goes on round it.
    context.arrived = meshes.Turned(qp.row, qp.active, rows) <= limits::mesh::kTurned;
    return false;
  }
  return context.IsRigid() && meshes.Relinearise(qp.row, qp.active, rows) != 0;
}

/// Where pairs that do not touch hold the tool at the trial, it has not arrived: the next sub-step
/// makes planes for them at the place that it comes to.  But without them the optimum may be free:
/// then it goes there.  Else they are what holds it: the next sub-step looks once more, and
/// where that finds no other place either, the tool has arrived.  False where nothing is free.
bool GoPast(StepContext& context) {
  MeshContact& meshes = *context.buffers.meshes;
  ContactRows& rows = context.buffers.rows;
  const auto release = [&] {
    const QpResult& qp = context.optimum.qp;
    return meshes.Release(qp.row, qp.active, rows);
  };
  if (release() == 0) return true;
  const Optimum held = context.optimum;
  const Vec3 v = context.v, phi = context.phi;
  GoToNewOptimum(context);
  if (context.Gain(context.v, context.phi) > context.Gain(v, phi) && IsFree(context)) {
    const bool held_again = release() != 0;
    meshes.PutBack(rows);
    context.arrived = context.arrived && !held_again;
    return true;
  }
  meshes.PutBack(rows);
  context.optimum = held;
  context.v = v;
  context.phi = phi;
  const bool stays = Way(context) <= limits::mesh::kTouching;
  context.arrived = stays && context.stuck_at == context.report.substeps - 1;
  if (stays) context.stuck_at = context.report.substeps;
  Remember(context);
  return IsFree(context);
}

/// Whether a motion that is free ends no farther from the hand than it begins, but for rounding.
/// What yields pushes as well: the optimum of both may lie farther from the hand.  So may a
/// straight way past a crease, where the arc ends nearer; and a ball that rests where facets have
/// lifted it.
bool Approaches(const StepContext& context) {
  const bool rests = context.IsFreeBall() && context.arrived;
  return !context.IsRigid() || context.rounds || rests ||
         context.Gain(context.v, context.phi) >= 0.0 || Way(context) <= limits::mesh::kRounding;
}

/// The sub-step begins anew with the rows as they are at its beginning; from the second time on the
/// tool is to go a quarter as far.  Rows that follow each trial may do so in turn for ever, or let
/// only such motions through as lead away from the hand; those of the beginning are true of a short
/// enough one, and none that is nearest to the hand under them leads away.
void BeginAnew(StepContext& context) {
  MeshContact& meshes = *context.buffers.meshes;
  ContactRows& rows = context.buffers.rows;
  meshes.GiveUpRegain(rows);
  // A ball's rows have the smooth surface's normals and not its facets': no motion is short enough.
  if (meshes.tool().radius > 0.0) {
    rows.AdmitZero();
    return;
  }
  TrustRegion& trust = context.trust;
  if (trust.begun_anew) {
    StepBounds& bounds = context.bounds;
    bounds.translation =
        std::min(bounds.translation, limits::mesh::kNarrow * trust.first.translation);
    bounds.rotation = std::min(bounds.rotation, limits::mesh::kNarrow * trust.first.rotation);
  }
  trust.begun_anew = true;
  trust.failures = 0;
  meshes.RelineariseAtStart(rows);
}

/// The longest half, quarter, ... of a motion that is not free.
void Halve(StepContext& context) {
  MeshContact& meshes = *context.buffers.meshes;
  context.arrived = false;
  context.state.friction = context.friction_before;  // of no trial
  while (!meshes.IsFull() && Way(context) > limits::mesh::kRounding) {
    context.v *= 0.5;
    context.phi *= 0.5;
    if (IsFree(context)) return;
  }
  context.v.setZero();
  context.phi.setZero();
  meshes.Stay();
}

}  // namespace

bool ClearWay(StepContext& context) noexcept {
  const double part = PartWithin(context);
  context.arrived = part == 1.0;
  GoTo(context, 1.0);
  if (!context.arrived) ShortenWay(context, part);
  if (!context.buffers.meshes) return true;
  MeshContact& meshes = *context.buffers.meshes;
  const bool goes_on = context.iterates < limits::mesh::kIterates;
  TrustRegion& trust = context.trust;
  if (trust.failures == 0) trust.first = {context.v.norm(), context.phi.norm()};
  const bool is_free = meshes.Check(context.v, TurnOfMesh(context), context.buffers.rows) == 0;
  if (is_free && Approaches(context)) {
    if (context.arrived && goes_on && Mend(context)) return false;
    // Of a ball, Turned says whether it has arrived.
    const bool is_ball = meshes.tool().radius > 0.0;
    if (is_ball || !context.IsRigid() || context.rounds || !context.arrived || GoPast(context)) {
      return true;
    }
  } else if (goes_on && !meshes.IsExhausted()) {
    if (is_free || ++trust.failures == limits::mesh::kTrustedTrials) BeginAnew(context);
    return false;
  }
  Halve(context);
  return true;
}

}  // namespace palpate
