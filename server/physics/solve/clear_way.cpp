#include "server/physics/solve/clear_way.h"

#include <algorithm>

#include "server/physics/contact/reconcile.h"
#include "server/physics/contact/sub_step.h"
#include "server/physics/contact/touch_rows.h"
#include "server/physics/limits.h"
#include "server/physics/solve/nearest_step.h"
#include "server/physics/solve/step_bounds.h"

namespace palpate {
namespace {

/// The part of the way to an optimum that the bounds allow.
double PartWithin(const StepContext& context, const Optimum& optimum) {
  return PartWithin(context.sub_step.bounds, context.model.degrees_of_freedom(), optimum.v,
                    optimum.phi);
}

/// Some part of the way to an optimum.
Way PartOfWay(const Optimum& optimum, double part) {
  return {optimum, part * optimum.v, part * optimum.phi, part == 1.0};
}

/// The way to the optimum under rows that have changed, as far as the bounds allow.  Where the QP
/// does not end the tool stays, and has not arrived.
Way WayToNewOptimum(StepContext& context) {
  const Optimum optimum = NearestStep(context, context.sub_step.target);
  context.report.qp_iterations += optimum.qp.iterations;
  Remember(context, optimum);
  context.Require(optimum);
  return PartOfWay(optimum, context.IsUnsolved() ? 0.0 : PartWithin(context, optimum));
}

/// The way to an optimum as far as the bounds allow.  Where they end before it: the step under the
/// same rows that is nearest to a nearer target.  A step that were only scaled down would make good
/// only a part of what rows ask for: of a lift of 0.1 mm so little less that the next trial were as
/// far from free as this one, and so each.
Way WayWithin(StepContext& context, const Optimum& optimum) {
  double part = PartWithin(context, optimum);
  if (part == 1.0) return PartOfWay(optimum, 1.0);
  for (int tries = 1;; ++tries) {
    part *= limits::kBoundShare;
    // The way to where the soft rows balance the spring: they have no part in it.
    const Optimum partial = NearestStep(context, {part * optimum.v, part * optimum.phi});
    context.report.qp_iterations += partial.qp.iterations;
    context.Require(partial);
    const double clip = context.IsUnsolved() ? 0.0 : PartWithin(context, partial);
    if (clip == 1.0 || clip == 0.0 || tries == limits::kNearerTargets) {
      return {optimum, clip * partial.v, clip * partial.phi, false};
    }
    part *= clip;
  }
}

/// How far a point of the tool's mesh goes at most.
double LengthOf(const StepContext& context, const Way& way) {
  return way.v.norm() + context.buffers.meshes->meshes.tool.mesh.reach() * way.phi.norm();
}

/// With 3 degrees of freedom no rotation moves a mesh.
Vec3 TurnOfMesh(const StepContext& context, const Way& way) {
  return context.model.degrees_of_freedom() == 6 ? way.phi : Vec3::Zero();
}

/// Whether the meshes are apart at the motion's end, and were on the way.
bool IsFree(const StepContext& context, const Way& way) {
  return IsFree(*context.buffers.meshes, way.v, TurnOfMesh(context, way));
}

/// Of a tool that arrives: whether rows change because they are not true of that place.
bool Mend(const StepContext& context, Way& way) {
  MeshContact& meshes = *context.buffers.meshes;
  ContactRows& rows = context.buffers.rows;
  const auto active = way.optimum.qp.ActiveRows();
  if (Retract(meshes, active, rows) != 0) return true;
  if (context.IsFreeBall()) {
    // A ball's rows have the smooth surface's normals at the trial, so the ball rests there, though
    // the facets on the way may have lifted it.  At a crease they have those of the beginning: the
    // ball has not arrived, and goes on round it.
    way.arrived = Turned(meshes, active, rows) <= limits::mesh::kTurned;
    return false;
  }
  return context.IsRigid() && Relinearise(meshes, active, rows) != 0;
}

/// Where pairs that do not touch hold the tool at a trial, it has not arrived: the next sub-step
/// makes planes for them at the place that it comes to.  But without them the optimum may be free:
/// then it goes there.  Else they are what holds it: the next sub-step looks once more, and
/// where that finds no other place either, the tool has arrived.  None where nothing is free.
std::optional<Way> GoPast(StepContext& context, const Way& held) {
  MeshContact& meshes = *context.buffers.meshes;
  ContactRows& rows = context.buffers.rows;
  if (Release(meshes, held.optimum.qp.ActiveRows(), rows) == 0) return held;
  Way past = WayToNewOptimum(context);
  if (context.Gain(past.v, past.phi) > context.Gain(held.v, held.phi) && IsFree(context, past)) {
    const bool held_again = Release(meshes, past.optimum.qp.ActiveRows(), rows) != 0;
    PutBack(meshes, rows);
    past.arrived = past.arrived && !held_again;
    return past;
  }
  PutBack(meshes, rows);
  const bool stays = LengthOf(context, held) <= meshes.meshes.margins.touching;
  Way again = held;
  again.arrived = stays && context.stuck_at == context.report.substeps - 1;
  if (stays) context.stuck_at = context.report.substeps;
  Remember(context, held.optimum);
  if (!IsFree(context, again)) return std::nullopt;
  return again;
}

/// Whether a motion that is free ends no farther from the hand than it begins, but for rounding.
/// What yields pushes as well: the optimum of both may lie farther from the hand.  So may a ball's:
/// on its way to where the smooth surface holds it facets may lift it, and a straight way past a
/// crease ends farther out than the arc.
bool Approaches(const StepContext& context, const Way& way) {
  return !context.IsRigid() || context.IsFreeBall() || context.Gain(way.v, way.phi) >= 0.0 ||
         LengthOf(context, way) <= limits::mesh::kRounding;
}

/// The sub-step begins anew with the rows as they are at its beginning; from the second time on the
/// tool is to go a quarter as far.  Rows that follow each trial may do so in turn for ever, or let
/// only such motions through as lead away from the hand; those of the beginning are true of a short
/// enough one, and none that is nearest to the hand under them leads away.
void BeginAnew(StepContext& context) {
  MeshContact& meshes = *context.buffers.meshes;
  ContactRows& rows = context.buffers.rows;
  GiveUpRegain(meshes, rows);
  // A ball's rows have the smooth surface's normals and not its facets': no motion is short enough.
  if (meshes.meshes.IsBall()) {
    rows.AdmitZero();
    return;
  }
  TrustRegion& trust = context.sub_step.trust;
  if (trust.begun_anew) {
    StepBounds& bounds = context.sub_step.bounds;
    bounds.translation =
        std::min(bounds.translation, limits::mesh::kNarrow * trust.first.translation);
    bounds.rotation = std::min(bounds.rotation, limits::mesh::kNarrow * trust.first.rotation);
  }
  trust.begun_anew = true;
  trust.failures = 0;
  RelineariseAtStart(meshes, rows);
}

/// The longest half, quarter, ... of a motion that is not free.
Way Halve(const StepContext& context, Way way) {
  MeshContact& meshes = *context.buffers.meshes;
  way.arrived = false;
  context.state.friction = context.sub_step.friction_before;  // of no trial
  while (!meshes.near.is_full() && LengthOf(context, way) > limits::mesh::kRounding) {
    way.v *= 0.5;
    way.phi *= 0.5;
    if (IsFree(context, way)) return way;
  }
  way.v.setZero();
  way.phi.setZero();
  Stay(meshes);
  return way;
}

}  // namespace

std::optional<Way> ClearWay(StepContext& context, const Optimum& optimum) noexcept {
  Way way = WayWithin(context, optimum);
  if (!context.buffers.meshes) return way;
  MeshContact& meshes = *context.buffers.meshes;
  const bool goes_on = context.sub_step.iterates < context.model.parameters().iterates;
  TrustRegion& trust = context.sub_step.trust;
  if (trust.failures == 0) trust.first = {way.v.norm(), way.phi.norm()};
  const bool is_free = CheckTrial(meshes, way.v, TurnOfMesh(context, way), context.buffers.rows);
  if (is_free && Approaches(context, way)) {
    if (way.arrived && goes_on && Mend(context, way)) return std::nullopt;
    // Of a ball, Turned says whether it has arrived.
    const bool goes_past =
        way.arrived && context.IsRigid() && !meshes.meshes.IsBall() && !optimum.rounds;
    if (!goes_past) return way;
    if (const auto past = GoPast(context, way)) return past;
  } else if (goes_on && !meshes.looks.AreSpent()) {
    if (is_free || ++trust.failures == limits::mesh::kTrustedTrials) BeginAnew(context);
    return std::nullopt;
  }
  return Halve(context, way);
}

}  // namespace palpate
