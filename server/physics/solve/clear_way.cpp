#include <algorithm>
#include <cmath>

#include "server/physics/contact/sub_step.h"
#include "server/physics/limits.h"
#include "server/physics/solve/stages.h"

namespace palpate {
namespace {

/// Returns the part of the way to an optimum that the bounds and a bur allow.
double PartWithin(const StepContext& context, const Optimum& optimum) {
  const double part = PartWithin(context.sub_step.bounds, optimum.v, optimum.phi);
  const auto& energies = context.buffers().energies;
  if (!energies || !context.state().cut.acts) return part;
  const Tools& tools = context.tools;
  return std::min(part, energies->PartWithin(tools.p_G, tools.q_G, optimum.v, optimum.phi));
}

/// Makes a way a part of the motion to its optimum.
void GoPart(Way& way, double part) {
  way.v = part * way.optimum.v;
  way.phi = part * way.optimum.phi;
  way.arrived = part == 1.0;
}

/// Returns the way to the optimum under rows that have changed, as far as the bounds allow.  If the
/// QP does not end, the tool stays and has not arrived.
Way WayToNewOptimum(StepContext& context) {
  Way way{NearestStep(context, context.sub_step.target)};
  context.report().diagnostics.qp_iterations += way.optimum.qp.iterations;
  Remember(context, way.optimum);
  context.Require(way.optimum);
  GoPart(way, context.IsUnsolved() ? 0.0 : PartWithin(context, way.optimum));
  return way;
}

/// Goes to a way's optimum as far as the bounds allow.  If they end before it, takes the step
/// under the same rows to a nearer target: a merely scaled-down one would achieve only a part of a
/// lift that rows ask for, and so would each trial after it.
void GoWithinBounds(StepContext& context, Way& way) {
  double part = PartWithin(context, way.optimum);
  GoPart(way, part);
  for (int tries = 1; !way.arrived; ++tries) {
    part *= limits::kBoundShare;
    // Soft rows balance the spring at the end of the way, so they take no part in this.
    const Optimum partial = NearestStep(context, {part * way.optimum.v, part * way.optimum.phi});
    context.report().diagnostics.qp_iterations += partial.qp.iterations;
    context.Require(partial);
    const double clip = context.IsUnsolved() ? 0.0 : PartWithin(context, partial);
    if (clip == 1.0 || clip == 0.0 || tries == limits::kNearerTargets) {
      way.v = clip * partial.v;
      way.phi = clip * partial.phi;
      return;
    }
    part *= clip;
  }
}

/// Returns how far a point of the tool's mesh moves at most.
double LengthOf(const StepContext& context, const Way& way) {
  return way.v.norm() + context.buffers().meshes->meshes.a.mesh.reach() * way.phi.norm();
}

/// Returns whether the meshes are apart at the motion's end and were apart on the way.
bool IsFree(StepContext& context, const Way& way) {
  return IsFree(*context.buffers().meshes, way.v, way.phi);
}

/// Returns by how much the direction of a row that holds a tool at rest may be off [rad]: that
/// changes the force by `error` [m], over k_t, or kTurned of it.
double MostTurned(const StepContext& context, const Optimum& optimum, double error) {
  const double rho = context.model.rotation_length();
  const double pull =
      std::sqrt((optimum.v - context.sub_step.target.v).squaredNorm() +
                rho * rho * (optimum.phi - context.sub_step.target.phi).squaredNorm());
  return std::clamp(error / pull, limits::mesh::kSame, limits::mesh::kTurned);
}

/// For a tool that arrives, returns whether rows changed because they are not true for that place.
bool Mend(StepContext& context, Way& way) {
  MeshContact& meshes = *context.buffers().meshes;
  ContactRows& rows = context.buffers().rows;
  const auto active = way.optimum.qp.ActiveRows();
  const bool retracts = meshes.meshes.IsBall() || !context.IsRigid();
  if (retracts && Retract(meshes, active, rows) != 0) return true;
  if (context.IsFreeBall()) {
    // A ball's rows have the smooth surface's normals at the trial, so the ball rests there, even
    // if facets lifted it on the way.  At a crease they have the normals of the beginning: the ball
    // has not arrived, and goes on round it.
    way.arrived = Turned(meshes, active, rows) <= limits::mesh::kTurned;
    return false;
  }
  if (meshes.meshes.IsBall() || !(context.IsRigid() || context.HasFriction())) return false;
  const double most = context.HasFriction()
                          ? limits::mesh::kSame
                          : MostTurned(context, way.optimum, limits::mesh::kForceError);
  return Relinearise(meshes, active, most, rows) != 0;
}

/// Goes only a part of a way.
void Shorten(Way& way, double part) {
  way.v *= part;
  way.phi *= part;
  way.part *= part;
}

/// Shortens a motion until it is free and paid for, to its half, quarter, ...; returns whether it
/// can be.
bool MakeFree(StepContext& context, Way& way) {
  const MeshContact& meshes = *context.buffers().meshes;
  while (!meshes.near.is_full() && !meshes.looks.AreSpent() &&
         LengthOf(context, way) > limits::mesh::kRounding) {
    if (IsFree(context, way)) return true;
    Shorten(way, 0.5);
  }
  return false;
}

/// What is to be done with a tool that reaches its optimum.
enum class Next {
  kGo,     ///< the way is free: go
  kStay,   ///< nothing is free
  kSolve,  ///< rows have changed: solve again
};

/// Decides whether a tool has arrived that reaches its optimum on a free way: only contacts may
/// hold it there (README.md, "Arrival").
/// @param goes_on  whether rows may change
Next Settle(StepContext& context, bool goes_on, Way& way) {
  MeshContact& meshes = *context.buffers().meshes;
  ContactRows& rows = context.buffers().rows;
  const auto active = way.optimum.qp.ActiveRows();
  const double most = MostTurned(context, way.optimum, limits::mesh::kReleaseError);
  if (AreOfContacts(meshes, active, most, rows)) return Next::kGo;
  if (goes_on && !meshes.looks.AreSpent() && !CheckRest(meshes, way.v, way.phi, rows)) {
    return Next::kSolve;
  }
  // The contacts of that place give the next sub-step its rows.  Two short steps in turn end the
  // search, if contacts of the beginning hold the tool; after one, a row at an edge may still turn.
  const bool stands = LengthOf(context, way) <= meshes.meshes.margins.touching;
  way.arrived = stands && context.outcome.stands;
  context.outcome.stands = stands;
  if (way.arrived && context.IsRigid() && Release(meshes, active, rows) != 0) {
    Way past = WayToNewOptimum(context);
    if (context.IsUnsolved()) return Next::kStay;
    if (MakeFree(context, past) && context.Gain(past.v, past.phi) > context.Gain(way.v, way.phi)) {
      way = past;
      way.arrived = false;
      return Next::kGo;
    }
    Remember(context, way.optimum);
  }
  return IsFree(context, way) ? Next::kGo : Next::kStay;
}

/// Returns whether a free motion ends no farther from the hand than it begins, except for rounding.
/// Energies push too, so their optimum with the coupling may lie farther from the hand.  So may a
/// ball's: facets may lift it on its way to where the smooth surface holds it, and a straight way
/// past a crease ends farther out than the arc.
bool Approaches(const StepContext& context, const Way& way) {
  return !context.IsRigid() || context.IsFreeBall() ||
         context.Approaches(way.optimum, way.v, way.phi) ||
         LengthOf(context, way) <= limits::mesh::kRounding;
}

/// Begins the sub-step anew with the rows as they are at its beginning; once they regain no
/// separation, the tool may go only a quarter as far (README.md, "Rest").
void BeginAnew(StepContext& context) {
  MeshContact& meshes = *context.buffers().meshes;
  ContactRows& rows = context.buffers().rows;
  const bool shorter = !GiveUpRegain(meshes, rows);
  // A ball's rows have the smooth surface's normals and not its facets', so no
  // motion is short enough.
  if (meshes.meshes.IsBall()) {
    rows.AdmitZero();
    return;
  }
  TrustRegion& trust = context.sub_step.trust;
  if (shorter) {
    StepBounds& bounds = context.sub_step.bounds;
    const double narrow = limits::mesh::kNarrow;
    bounds = Clamped(context.model.parameters(),
                     {std::min(bounds.translation, narrow * trust.first.translation),
                      std::min(bounds.rotation, narrow * trust.first.rotation)});
    trust.shrunk = true;
  }
  trust.failures = 0;
  RelineariseAtStart(meshes, rows);
}

/// Shortens a motion to the longest half, quarter, ... that is free and paid for, or to none.
void Halve(StepContext& context, Way& way) {
  MeshContact& meshes = *context.buffers().meshes;
  way.arrived = false;
  if (context.HasFriction()) context.friction = context.state().friction;
  meshes.looks.most += context.model.parameters().looks / limits::mesh::kReserve;
  // What held the tool at the beginning still does, and not what a trial met that is given up.
  context.sub_step.active = context.state().active;
  Shorten(way, 0.5);
  if (MakeFree(context, way)) return;
  way.v.setZero();
  way.phi.setZero();
  way.part = 0.0;
  meshes.motion = Motion(meshes.motion.from);
}

}  // namespace

bool ClearWay(StepContext& context, Way& way) noexcept {
  GoWithinBounds(context, way);
  if (!Foresees(context, way)) return false;
  if (!context.buffers().meshes) return true;
  MeshContact& meshes = *context.buffers().meshes;
  const bool goes_on = context.sub_step.iterates < context.model.parameters().iterates;
  TrustRegion& trust = context.sub_step.trust;
  if (trust.failures == 0) trust.first = {way.v.norm(), way.phi.norm()};
  const bool is_free = CheckTrial(meshes, way.v, way.phi, context.buffers().rows);
  if (is_free && Approaches(context, way)) {
    if (way.arrived && goes_on && Mend(context, way)) return false;
    // For a ball, Turned decides whether it has arrived.
    const bool may_settle = context.IsRigid() || context.HasFriction();
    if (way.arrived && may_settle && !meshes.meshes.IsBall() && !way.optimum.rounds) {
      const Next next = Settle(context, goes_on, way);
      if (next != Next::kStay) return next == Next::kGo;
    } else {
      return true;
    }
  } else if (goes_on && !meshes.looks.AreSpent()) {
    if (is_free || ++trust.failures == limits::mesh::kTrustedTrials) BeginAnew(context);
    return false;
  }
  Halve(context, way);
  return true;
}

}  // namespace palpate
