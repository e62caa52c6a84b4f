#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "server/physics/contact/sub_step.h"
#include "server/physics/limits.h"
#include "server/physics/solve/stages.h"

namespace palpate {
namespace {

/// Calls f(tool, contact, rows) for each frame of each tool; returns whether all, or how many in
/// sum, it returns.
template <class F>
bool All(Party tools, F f) {
  bool all = true;
  for (StepContext* tool : tools) {
    for (MeshContact& contact : tool->buffers().meshes->of) {
      FrameRows rows(tool->buffers().rows, contact.moved);
      all = f(*tool, contact, rows) && all;
    }
  }
  return all;
}
template <class F>
int Sum(Party tools, F f) {
  int sum = 0;
  All(tools, [&](StepContext& tool, MeshContact& contact, FrameRows& rows) {
    sum += f(tool, contact, rows);
    return true;
  });
  return sum;
}

bool QueriesAreSpent(Party tools) {
  return std::ranges::any_of(
      tools, [](const StepContext* tool) { return tool->buffers().meshes->queries.AreSpent(); });
}

/// Returns the fraction of the motions to the optima that the bounds and a bur allow.
template <class OptimumOf>
double FractionWithin(Party tools, OptimumOf optimum_of) {
  double least = 1.0;
  for (StepContext* tool : tools) {
    const Optimum& end = optimum_of(*tool);
    least = std::min(least, FractionWithin(tool->sub_step.bounds, end.v, end.phi));
    const auto& energies = tool->buffers().energies;
    if (!energies || !tool->state().cut.acts) continue;
    least =
        std::min(least, energies->FractionWithin(tool->tools.p_G, tool->tools.q_G, end.v, end.phi));
  }
  return least;
}

const Optimum& NearestOf(const StepContext& tool) {
  return tool.nearest;
}
const Optimum& OptimumOf(const StepContext& tool) {
  return tool.advance.optimum;
}

/// Advances by a fraction of the motion to the optimum.
void GoFraction(Party tools, double fraction) {
  for (StepContext* tool : tools) {
    Advance& advance = tool->advance;
    advance.v = fraction * advance.optimum.v;
    advance.phi = fraction * advance.optimum.phi;
    advance.arrived = fraction == 1.0;
  }
}

/// Takes over the nearest steps under rows that have changed, and advances there as far as the
/// bounds allow.  If the QP does not end, the tools stay and have not arrived.
void AdvanceToNewOptima(Party tools) {
  for (StepContext* tool : tools) tool->goal = tool->sub_step.target;
  NearestSteps(tools);
  for (StepContext* tool : tools) {
    tool->advance = Advance{tool->nearest};
    tool->report().diagnostics.qp_iterations += tool->nearest.qp.iterations;
    Remember(*tool, tool->nearest);
    tool->Require(tool->nearest);
  }
  GoFraction(tools, AreUnsolved(tools) ? 0.0 : FractionWithin(tools, NearestOf));
}

/// Advances to the optimum as far as the bounds allow.  If they end before it, takes the step under
/// the same rows to a nearer target: a scaled-down step would lift the tool by less than rows ask
/// for, and so would each candidate after it.
void GoWithinBounds(Party tools) {
  double fraction = FractionWithin(tools, OptimumOf);
  GoFraction(tools, fraction);
  for (int tries = 1; !Lead(tools).advance.arrived; ++tries) {
    fraction *= limits::kBoundShare;
    // Soft rows balance the spring at the optimum alone, so they do not count here.
    for (StepContext* tool : tools) {
      const Optimum& optimum = tool->advance.optimum;
      tool->goal = {fraction * optimum.v, fraction * optimum.phi};
    }
    NearestSteps(tools);
    for (StepContext* tool : tools) {
      tool->report().diagnostics.qp_iterations += tool->nearest.qp.iterations;
      tool->Require(tool->nearest);
    }
    const double clip = AreUnsolved(tools) ? 0.0 : FractionWithin(tools, NearestOf);
    if (clip == 1.0 || clip == 0.0 || tries == limits::kNearerTargets) {
      for (StepContext* tool : tools) {
        tool->advance.v = clip * tool->nearest.v;
        tool->advance.phi = clip * tool->nearest.phi;
      }
      return;
    }
    fraction *= clip;
  }
}

/// Returns how far a point of a tool's mesh moves at most.
double LengthOf(Party tools) {
  double most = 0.0;
  for (const StepContext* tool : tools) {
    const Advance& advance = tool->advance;
    most = std::max(
        most, advance.v.norm() + tool->buffers().meshes->a().mesh.reach() * advance.phi.norm());
  }
  return most;
}

/// Returns whether the meshes are apart at the motion's end and were apart throughout.
bool AreFree(Party tools) {
  for (StepContext* tool : tools) PlaceFrames(*tool, tool->advance.of_frames);
  PlaceTools(tools);
  return std::ranges::all_of(tools, [&](StepContext* tool) {
    return std::ranges::all_of(tool->buffers().meshes->of, [&](MeshContact& contact) {
      return IsFree(contact, contact.moved.v(tool->advance.v),
                    contact.moved.phi(tool->advance.phi));
    });
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

/// Returns whether the candidate and the last that no contact held are short: the contacts at
/// their beginning then hold the tools.
bool Stands(Party tools) {
  const bool stands = LengthOf(tools) <= Lead(tools).buffers().meshes->margins().touching;
  return std::exchange(Lead(tools).outcome.stands, stands) && stands;
}

/// For tools that arrive, returns whether rows changed because they are not true for that place.
bool Mend(Party tools) {
  StepContext& lead = Lead(tools);
  const auto retract = [&](StepContext& tool, MeshContact& contact, FrameRows& rows) {
    const bool may = contact.meshes.IsBall() || !tool.IsRigid();
    return may ? Retract(contact, tool.advance.optimum.qp.ActiveRows(), rows) : 0;
  };
  if (Sum(tools, retract) != 0) return true;
  if (tools.size() == 1 && lead.IsFreeBall()) {
    // A ball's rows have the smooth surface's normals at the candidate, so the ball rests there,
    // even if facets lifted it as it went.  At a crease they have the normals of the beginning: the
    // ball has not arrived, and goes on round it.
    const auto are_true = [](StepContext& tool, MeshContact& contact, FrameRows& rows) {
      return Turned(contact, tool.advance.optimum.qp.ActiveRows(), rows) <= limits::mesh::kTurned;
    };
    const bool stands = Stands(tools);
    lead.advance.arrived = All(tools, are_true) || stands;
    return false;
  }
  const auto relinearise = [&](StepContext& tool, MeshContact& contact, FrameRows& rows) {
    if (contact.meshes.IsBall() || !tool.IsHeldByRows()) return 0;
    const double most = tool.HasFriction()
                            ? limits::mesh::kSame
                            : MostTurned(tool, tool.advance.optimum, limits::mesh::kForceError);
    return Relinearise(contact, tool.advance.optimum.qp.ActiveRows(), most, rows);
  };
  return Sum(tools, relinearise) != 0;
}

/// Advances by a fraction of the motion only.
void Shorten(Party tools, double fraction) {
  for (StepContext* tool : tools) {
    Advance& advance = tool->advance;
    advance.v *= fraction;
    advance.phi *= fraction;
    advance.fraction *= fraction;
    advance.of_frames *= fraction;
  }
}

/// Shortens the motions until they are free and paid for, to their half, quarter, ...; returns
/// whether they can be.
bool MakeFree(Party tools) {
  const auto is_full = [](const StepContext* tool) {
    return std::ranges::any_of(tool->buffers().meshes->of,
                               [](const MeshContact& contact) { return contact.near.is_full(); });
  };
  while (std::ranges::none_of(tools, is_full) && !QueriesAreSpent(tools) &&
         LengthOf(tools) > limits::mesh::kRounding) {
    if (AreFree(tools)) return true;
    Shorten(tools, 0.5);
  }
  return false;
}

/// Returns how much nearer to the hands the motions end than they begin, over k_t of the first
/// [m^2].
double GainOf(Party tools) {
  double gain = 0.0;
  for (const StepContext* tool : tools) {
    gain += tool->weight * tool->Gain(tool->advance.v, tool->advance.phi);
  }
  return gain;
}

/// What is to be done with a tool that reaches its optimum.
enum class Next {
  kGo,     ///< the motion is free: go
  kStay,   ///< nothing is free
  kSolve,  ///< rows have changed: solve again
};

/// Decides whether tools have arrived that reach their optimum by a free motion: only contacts may
/// hold them there (README.md, "Arrival").
/// @param goes_on  whether rows may change
Next Settle(Party tools, bool goes_on) {
  const auto are_of_contacts = [&](StepContext& tool, MeshContact& contact, FrameRows& rows) {
    const Optimum& optimum = tool.advance.optimum;
    const double most = MostTurned(tool, optimum, limits::mesh::kReleaseError);
    return AreOfContacts(contact, optimum.qp.ActiveRows(), most, rows);
  };
  const auto may_rest = [&](StepContext& tool, MeshContact& contact, FrameRows& rows) {
    return CheckRest(contact, contact.moved.v(tool.advance.v), contact.moved.phi(tool.advance.phi),
                     rows);
  };
  const auto release = [&](StepContext& tool, MeshContact& contact, FrameRows& rows) {
    return tool.IsRigid() ? Release(contact, tool.advance.optimum.qp.ActiveRows(), rows) : 0;
  };
  if (All(tools, are_of_contacts)) return Next::kGo;
  if (goes_on && !QueriesAreSpent(tools) && !All(tools, may_rest)) return Next::kSolve;
  // The contacts of that place give the next sub-step its rows.  Two short steps in turn end the
  // search, if contacts of the beginning hold the tool; after one, a row at an edge may still turn.
  const bool arrived = Stands(tools);
  for (StepContext* tool : tools) tool->advance.arrived = arrived;
  if (arrived && Sum(tools, release) != 0) {
    const double gain = GainOf(tools);
    std::array<Advance, kMostMembers> held;
    for (std::size_t i = 0; i < tools.size(); ++i) held[i] = tools[i]->advance;
    AdvanceToNewOptima(tools);
    if (AreUnsolved(tools)) return Next::kStay;
    if (MakeFree(tools) && GainOf(tools) > gain) {
      for (StepContext* tool : tools) tool->advance.arrived = false;
      return Next::kGo;
    }
    for (std::size_t i = 0; i < tools.size(); ++i) {
      tools[i]->advance = held[i];
      Remember(*tools[i], held[i].optimum);
    }
  }
  return AreFree(tools) ? Next::kGo : Next::kStay;
}

/// Returns whether free motions end no farther from the hands than they begin, except for rounding.
/// Energies push too, so their optimum with the coupling may lie farther from the hand.  So may a
/// ball's: facets may lift it as it goes to where the smooth surface holds it, and a straight
/// motion past a crease ends farther out than the arc.
bool Approach(Party tools) {
  const StepContext& lead = Lead(tools);
  return !lead.IsRigid() || (tools.size() == 1 && lead.IsFreeBall()) || AdvancesApproach(tools) ||
         LengthOf(tools) <= limits::mesh::kRounding;
}

/// Begins the sub-step anew with the rows as they are at its beginning; once they regain no
/// separation, the tools may go only a quarter as far (README.md, "Rest").
void BeginAnew(Party tools) {
  const bool shorter = !GiveUpRegain(tools);
  for (StepContext* tool : tools) {
    // A ball's rows have the smooth surface's normals and not its facets', so no
    // motion is short enough.
    if (tool->buffers().meshes->IsBall()) continue;
    TrustRegion& trust = tool->sub_step.trust;
    if (shorter) {
      StepBounds& bounds = tool->sub_step.bounds;
      const double narrow = limits::mesh::kNarrow;
      bounds = Clamped(tool->model.parameters(),
                       {std::min(bounds.translation, narrow * trust.first.translation),
                        std::min(bounds.rotation, narrow * trust.first.rotation)});
      trust.shrunk = true;
    }
    trust.failures = 0;
    tool->advance.v.setZero();
    tool->advance.phi.setZero();
  }
  if (shorter) BeginFrames(tools, true);
  PlaceTools(tools);
  Sum(tools, [](StepContext& tool, MeshContact& contact, FrameRows& rows) {
    if (contact.meshes.IsBall()) {
      tool.buffers().rows.AdmitZero();
    } else {
      RelineariseAtStart(contact, rows);
    }
    return 0;
  });
}

/// Shortens the motions to their longest half, quarter, ... that is free and paid for, or to none.
void Halve(Party tools) {
  for (StepContext* tool : tools) {
    tool->advance.arrived = false;
    if (tool->HasFriction()) tool->friction = tool->state().friction;
    tool->buffers().meshes->queries.most +=
        tool->model.parameters().queries / limits::mesh::kReserve;
    // What held the tool at the beginning still does, and not what a candidate met that is given
    // up.
    tool->sub_step.active = tool->state().active;
  }
  Shorten(tools, 0.5);
  if (MakeFree(tools)) return;
  for (StepContext* tool : tools) {
    Advance& advance = tool->advance;
    advance.v.setZero();
    advance.phi.setZero();
    advance.fraction = advance.of_frames = 0.0;
    for (MeshContact& contact : tool->buffers().meshes->of) {
      contact.motion = Motion(contact.motion.from);
    }
  }
}

}  // namespace

bool AdvancesApproach(Party tools) noexcept {
  double gain = 0.0;
  for (const StepContext* tool : tools) {
    if (tool->BodiesMove()) return true;
    const Advance& step = tool->advance;
    const BodyContact& meshes = *tool->buffers().meshes;
    const double length = step.v.norm() + meshes.a().mesh.reach() * step.phi.norm();
    double price = 0.0;
    if (length <= meshes.margins().touching) {
      for (const MeshContact& contact : meshes.of) {
        price += PriceOfRegain(contact, step.optimum.qp);
      }
    }
    gain += tool->weight * (tool->Gain(step.v, step.phi) + 2.0 * price);
  }
  return gain >= 0.0;
}

bool CheckCandidate(Party tools) noexcept {
  PlaceTools(tools);
  return All(tools, [](StepContext& tool, MeshContact& contact, FrameRows& rows) {
    return CheckCandidate(contact, contact.moved.v(tool.advance.v),
                          contact.moved.phi(tool.advance.phi), rows);
  });
}

bool GiveUpRegain(Party tools) noexcept {
  return Sum(tools, [](StepContext&, MeshContact& contact, FrameRows& rows) {
           return GiveUpRegain(contact, rows) ? 1 : 0;
         }) != 0;
}

bool MakeAdvance(Party tools) noexcept {
  StepContext& lead = Lead(tools);
  GoWithinBounds(tools);
  if (!Foresees(lead)) return false;
  if (!lead.buffers().meshes) return true;
  const bool goes_on = lead.sub_step.iterates < lead.model.parameters().iterates;
  const bool is_trusted = lead.sub_step.trust.failures > 0;
  for (StepContext* tool : tools) {
    if (!is_trusted)
      tool->sub_step.trust.first = {tool->advance.v.norm(), tool->advance.phi.norm()};
  }
  const bool is_free = CheckCandidate(tools);
  if (is_free && Approach(tools)) {
    if (lead.advance.arrived && goes_on && Mend(tools)) return false;
    // For a ball, Turned decides whether it has arrived.
    const bool may_settle = lead.IsHeldByRows();
    const bool is_ball = tools.size() == 1 && lead.buffers().meshes->IsBall();
    if (lead.advance.arrived && may_settle && !is_ball && !lead.advance.optimum.rounds) {
      const Next next = Settle(tools, goes_on);
      if (next != Next::kStay) return next == Next::kGo;
    } else {
      return true;
    }
  } else if (goes_on && !QueriesAreSpent(tools)) {
    if (is_free || ++lead.sub_step.trust.failures == limits::mesh::kTrustedCandidates) {
      BeginAnew(tools);
    }
    return false;
  }
  Halve(tools);
  return true;
}

}  // namespace palpate
