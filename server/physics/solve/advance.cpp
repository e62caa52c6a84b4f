#include <algorithm>
#include <cmath>

#include "server/physics/contact/sub_step.h"
#include "server/physics/limits.h"
#include "server/physics/solve/stages.h"

namespace palpate {
namespace {

/// Returns the fraction of the motion to an optimum that the bounds and a bur allow.
double FractionWithin(const StepContext& context, const Optimum& optimum) {
  const double fraction = FractionWithin(context.sub_step.bounds, optimum.v, optimum.phi);
  const auto& energies = context.buffers().energies;
  if (!energies || !context.state().cut.acts) return fraction;
  const Tools& tools = context.tools;
  return std::min(fraction, energies->FractionWithin(tools.p_G, tools.q_G, optimum.v, optimum.phi));
}

/// Advances by a fraction of the motion to the optimum.
void GoFraction(Advance& advance, double fraction) {
  advance.v = fraction * advance.optimum.v;
  advance.phi = fraction * advance.optimum.phi;
  advance.arrived = fraction == 1.0;
}

/// Returns the advance to the optimum under rows that have changed, as far as the bounds allow.  If
/// the QP does not end, the tool stays and has not arrived.
Advance AdvanceToNewOptimum(StepContext& context) {
  Advance advance{NearestStep(context, context.sub_step.target)};
  context.report().diagnostics.qp_iterations += advance.optimum.qp.iterations;
  Remember(context, advance.optimum);
  context.Require(advance.optimum);
  GoFraction(advance, context.IsUnsolved() ? 0.0 : FractionWithin(context, advance.optimum));
  return advance;
}

/// Advances to the optimum as far as the bounds allow.  If they end before it, takes the step under
/// the same rows to a nearer target: a scaled-down step would lift the tool by less than rows ask
/// for, and so would each candidate after it.
void GoWithinBounds(StepContext& context, Advance& advance) {
  double fraction = FractionWithin(context, advance.optimum);
  GoFraction(advance, fraction);
  for (int tries = 1; !advance.arrived; ++tries) {
    fraction *= limits::kBoundShare;
    // Soft rows balance the spring at the optimum alone, so they do not count here.
    const Optimum partial =
        NearestStep(context, {fraction * advance.optimum.v, fraction * advance.optimum.phi});
    context.report().diagnostics.qp_iterations += partial.qp.iterations;
    context.Require(partial);
    const double clip = context.IsUnsolved() ? 0.0 : FractionWithin(context, partial);
    if (clip == 1.0 || clip == 0.0 || tries == limits::kNearerTargets) {
      advance.v = clip * partial.v;
      advance.phi = clip * partial.phi;
      return;
    }
    fraction *= clip;
  }
}

/// Returns how far a point of the tool's mesh moves at most.
double LengthOf(const StepContext& context, const Advance& advance) {
  return advance.v.norm() + context.buffers().meshes->a().mesh.reach() * advance.phi.norm();
}

/// Returns whether the meshes are apart at the motion's end and were apart throughout.
bool IsFree(StepContext& context, const Advance& advance) {
  PlaceFrames(context, advance.of_frames);
  return std::ranges::all_of(context.buffers().meshes->of, [&](MeshContact& contact) {
    return IsFree(contact, contact.moved.v(advance.v), contact.moved.phi(advance.phi));
  });
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
bool Mend(StepContext& context, Advance& advance) {
  BodyContact& meshes = *context.buffers().meshes;
  ContactRows& rows = context.buffers().rows;
  const auto active = advance.optimum.qp.ActiveRows();
  const auto retract = [&](MeshContact& contact) {
    FrameRows in_B(rows, contact.moved);
    return Retract(contact, active, in_B);
  };
  if ((meshes.IsBall() || !context.IsRigid()) && meshes.Sum(retract) != 0) return true;
  if (context.IsFreeBall()) {
    // A ball's rows have the smooth surface's normals at the candidate, so the ball rests there,
    // even if facets lifted it as it went.  At a crease they have the normals of the beginning: the
    // ball has not arrived, and goes on round it.
    advance.arrived = meshes.All([&](const MeshContact& contact) {
      return Turned(contact, active, FrameRows(rows, contact.moved)) <= limits::mesh::kTurned;
    });
    return false;
  }
  if (meshes.IsBall() || !context.IsHeldByRows()) return false;
  const double most = context.HasFriction()
                          ? limits::mesh::kSame
                          : MostTurned(context, advance.optimum, limits::mesh::kForceError);
  return meshes.Sum([&](MeshContact& contact) {
    FrameRows in_B(rows, contact.moved);
    return Relinearise(contact, active, most, in_B);
  }) != 0;
}

/// Advances by a fraction of the motion only.
void Shorten(Advance& advance, double fraction) {
  advance.v *= fraction;
  advance.phi *= fraction;
  advance.fraction *= fraction;
  advance.of_frames *= fraction;
}

/// Shortens a motion until it is free and paid for, to its half, quarter, ...; returns whether it
/// can be.
bool MakeFree(StepContext& context, Advance& advance) {
  const BodyContact& meshes = *context.buffers().meshes;
  const auto is_full = [](const MeshContact& contact) { return contact.near.is_full(); };
  while (std::ranges::none_of(meshes.of, is_full) && !meshes.queries.AreSpent() &&
         LengthOf(context, advance) > limits::mesh::kRounding) {
    if (IsFree(context, advance)) return true;
    Shorten(advance, 0.5);
  }
  return false;
}

/// What is to be done with a tool that reaches its optimum.
enum class Next {
  kGo,     ///< the motion is free: go
  kStay,   ///< nothing is free
  kSolve,  ///< rows have changed: solve again
};

/// Decides whether a tool has arrived that reaches its optimum by a free motion: only contacts may
/// hold it there (README.md, "Arrival").
/// @param goes_on  whether rows may change
Next Settle(StepContext& context, bool goes_on, Advance& advance) {
  BodyContact& meshes = *context.buffers().meshes;
  ContactRows& rows = context.buffers().rows;
  const auto active = advance.optimum.qp.ActiveRows();
  const double most = MostTurned(context, advance.optimum, limits::mesh::kReleaseError);
  const auto are_of_contacts = [&](const MeshContact& contact) {
    return AreOfContacts(contact, active, most, FrameRows(rows, contact.moved));
  };
  const auto may_rest = [&](MeshContact& contact) {
    FrameRows in_B(rows, contact.moved);
    return CheckRest(contact, contact.moved.v(advance.v), contact.moved.phi(advance.phi), in_B);
  };
  const auto release = [&](MeshContact& contact) {
    FrameRows in_B(rows, contact.moved);
    return Release(contact, active, in_B);
  };
  if (meshes.All(are_of_contacts)) return Next::kGo;
  if (goes_on && !meshes.queries.AreSpent() && !meshes.All(may_rest)) return Next::kSolve;
  // The contacts of that place give the next sub-step its rows.  Two short steps in turn end the
  // search, if contacts of the beginning hold the tool; after one, a row at an edge may still turn.
  const bool stands = LengthOf(context, advance) <= meshes.margins().touching;
  advance.arrived = stands && context.outcome.stands;
  context.outcome.stands = stands;
  if (advance.arrived && context.IsRigid() && meshes.Sum(release) != 0) {
    Advance past = AdvanceToNewOptimum(context);
    if (context.IsUnsolved()) return Next::kStay;
    if (MakeFree(context, past) &&
        context.Gain(past.v, past.phi) > context.Gain(advance.v, advance.phi)) {
      advance = past;
      advance.arrived = false;
      return Next::kGo;
    }
    Remember(context, advance.optimum);
  }
  return IsFree(context, advance) ? Next::kGo : Next::kStay;
}

/// Returns whether a free motion ends no farther from the hand than it begins, except for rounding.
/// Energies push too, so their optimum with the coupling may lie farther from the hand.  So may a
/// ball's: facets may lift it as it goes to where the smooth surface holds it, and a straight
/// motion past a crease ends farther out than the arc.
bool Approaches(const StepContext& context, const Advance& advance) {
  return !context.IsRigid() || context.IsFreeBall() ||
         context.Approaches(advance.optimum, advance.v, advance.phi) ||
         LengthOf(context, advance) <= limits::mesh::kRounding;
}

/// Begins the sub-step anew with the rows as they are at its beginning; once they regain no
/// separation, the tool may go only a quarter as far (README.md, "Rest").
void BeginAnew(StepContext& context) {
  BodyContact& meshes = *context.buffers().meshes;
  ContactRows& rows = context.buffers().rows;
  const bool shorter = !GiveUpRegain(context);
  // A ball's rows have the smooth surface's normals and not its facets', so no
  // motion is short enough.
  if (meshes.IsBall()) {
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
    BeginFrames(context, true);
    trust.shrunk = true;
  }
  trust.failures = 0;
  for (MeshContact& contact : meshes.of) {
    FrameRows in_B(rows, contact.moved);
    RelineariseAtStart(contact, in_B);
  }
}

/// Shortens a motion to the longest half, quarter, ... that is free and paid for, or to none.
void Halve(StepContext& context, Advance& advance) {
  BodyContact& meshes = *context.buffers().meshes;
  advance.arrived = false;
  if (context.HasFriction()) context.friction = context.state().friction;
  meshes.queries.most += context.model.parameters().queries / limits::mesh::kReserve;
  // What held the tool at the beginning still does, and not what a candidate met that is given up.
  context.sub_step.active = context.state().active;
  Shorten(advance, 0.5);
  if (MakeFree(context, advance)) return;
  advance.v.setZero();
  advance.phi.setZero();
  advance.fraction = advance.of_frames = 0.0;
  for (MeshContact& contact : meshes.of) contact.motion = Motion(contact.motion.from);
}

}  // namespace

bool CheckCandidate(StepContext& context, const Vec3& v, const Vec3& phi) noexcept {
  return context.buffers().meshes->All([&](MeshContact& contact) {
    FrameRows rows(context.buffers().rows, contact.moved);
    return CheckCandidate(contact, contact.moved.v(v), contact.moved.phi(phi), rows);
  });
}

bool GiveUpRegain(StepContext& context) noexcept {
  return context.buffers().meshes->Sum([&](MeshContact& contact) {
    FrameRows rows(context.buffers().rows, contact.moved);
    return GiveUpRegain(contact, rows) ? 1 : 0;
  }) != 0;
}

bool MakeAdvance(StepContext& context, Advance& advance) noexcept {
  GoWithinBounds(context, advance);
  if (!Foresees(context, advance)) return false;
  if (!context.buffers().meshes) return true;
  const BodyContact& meshes = *context.buffers().meshes;
  const bool goes_on = context.sub_step.iterates < context.model.parameters().iterates;
  TrustRegion& trust = context.sub_step.trust;
  if (trust.failures == 0) trust.first = {advance.v.norm(), advance.phi.norm()};
  const bool is_free = CheckCandidate(context, advance.v, advance.phi);
  if (is_free && Approaches(context, advance)) {
    if (advance.arrived && goes_on && Mend(context, advance)) return false;
    // For a ball, Turned decides whether it has arrived.
    const bool may_settle = context.IsHeldByRows();
    if (advance.arrived && may_settle && !meshes.IsBall() && !advance.optimum.rounds) {
      const Next next = Settle(context, goes_on, advance);
      if (next != Next::kStay) return next == Next::kGo;
    } else {
      return true;
    }
  } else if (goes_on && !meshes.queries.AreSpent()) {
    if (is_free || ++trust.failures == limits::mesh::kTrustedCandidates) BeginAnew(context);
    return false;
  }
  Halve(context, advance);
  return true;
}

}  // namespace palpate
