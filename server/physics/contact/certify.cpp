#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>
#include <limits>
#include <span>
#include <utility>

#include "server/physics/contact/sub_step.h"
#include "server/physics/limits.h"
#include "server/physics/surface/separating_plane.h"

namespace palpate {
namespace {

using namespace limits::mesh;
using Index = NearPairs::Index;

/// Packs a near pair whose plane does not hold at a candidate, and the gap that is left along it,
/// into one number that sorts like the gap.  The index replaces the last bits of the gap: `room` is
/// a power of two above every index.
std::int64_t DoubtOf(double gap, Index near, std::int64_t room) {
  auto bits = std::bit_cast<std::int64_t>(gap);
  bits ^= (bits >> 63) & std::numeric_limits<std::int64_t>::max();  // so that integers
                                                                    // sort as gaps do
  return (bits & ~(room - 1)) | near;
}
Index NearOf(std::int64_t doubt, std::int64_t room) {
  return static_cast<Index>(doubt & (room - 1));
}

/// Puts a number into a heap, at `hole` or below, where all below is one.  Unlike std::pop_heap, it
/// has no branch on which of two is less, which could not be predicted.
void Sink(std::span<std::int64_t> heap, std::size_t hole, std::int64_t number) {
  const std::size_t top = hole;
  std::size_t child = 2 * hole + 1;
  for (; child + 1 < heap.size(); child = 2 * hole + 1) {
    child += heap[child + 1] < heap[child] ? 1 : 0;
    heap[hole] = heap[child];
    hole = child;
  }
  if (child < heap.size()) heap[std::exchange(hole, child)] = heap[child];
  for (; hole > top && number < heap[(hole - 1) / 2]; hole = (hole - 1) / 2) {
    heap[hole] = heap[(hole - 1) / 2];
  }
  heap[hole] = number;
}

std::int64_t PopLeast(std::vector<std::int64_t>& heap) {
  const std::int64_t least = heap.front(), last = heap.back();
  heap.pop_back();
  if (!heap.empty()) Sink(heap, 0, last);
  return least;
}

/// Returns whether one of some planes separates a pair throughout the candidate by enough
/// (`proves`, of the gaps before and after); if so, sets the first such one as the pair's plane.
template <class Proves>
bool Hold(MeshContact& contact, Index k, TriedPlanes& planes, Proves proves) {
  return planes.Find([&](int i) {
    const double before = planes.before(i), after = planes.after(i);
    if (!proves(before, after)) return false;
    if (planes.plane(i).of != ContactPlane::Of::kB &&
        std::min(before, after) - planes.Loss(i) <
            0.5 * std::min(contact.meshes.margins.free, before)) {
      return false;
    }
    contact.near.SetPlanes(k, planes.n_before(i), before, planes.n_after(i), after);
    return true;
  });
}

/// Returns whether two triangles are separate, by planes that can belong to a contact.  No other
/// plane is tried, because it would let the tool pass where the next sub-step would then stop it.
[[gnu::flatten]] bool TrianglesApart(MeshContact& contact, Index k) {
  const MeshPair& meshes = contact.meshes;
  const Motion& motion = contact.motion;
  const Touch& touch = contact.TouchOf(k);
  TriedPlanes planes(meshes, touch.nodes, motion);
  bool held = false;
  const auto try_all = [&] {
    return held = held || Hold(contact, k, planes, [&](double before, double after) {
                    return touch.Proves(meshes.margins, before, after);
                  });
  };
  const auto add = [&](const Touch& of, const ContactPlane& plane) {
    if (planes.IsFull()) try_all();
    if (!held) planes.Add(of, plane);
  };
  const auto add_fixed = [&](const Vec3& n) { add(touch, {ContactPlane::Of::kB, n}); };
  if (touch.plane.of != ContactPlane::Of::kNone) add(touch, touch.plane);
  add_fixed(touch.u);
  if (!touch.is_behind) add_fixed(contact.near.Normal(k));
  if (try_all() || touch.is_behind) return held;
  ForEachFace(meshes, touch.nodes, touch.nearest, motion.from,
              [&](const ContactPlane& plane) { add(touch, plane); });
  if (try_all() || !motion.moves) return held;
  const NearestPoints nearest = meshes.NearestAt(touch.nodes, motion.to);
  if (nearest.squared > 0.0) add_fixed(DirectionAt(meshes, touch.nodes, nearest, motion.to));
  if (try_all()) return true;
  if (touch.in_cone) {
    if (touch.plane.of == ContactPlane::Of::kNone) add(touch, ChoosePlane(meshes, touch, motion));
    return try_all();
  }
  // The plane of a neighbouring contact restricts nothing that the contact does not.
  for (const Touch& other : contact.touches) {
    if (other.in_cone && other.plane.of != ContactPlane::Of::kNone) add(other, other.plane);
  }
  return try_all();
}

/// Returns whether two triangles, apart throughout a candidate, may be as they are at its end if
/// the tool rests there.  A plane of a neighbour proves less than a contact keeps.
bool MayRestApart(MeshContact& contact, Index k) {
  const MeshPair& meshes = contact.meshes;
  const Touch& touch = contact.TouchOf(k);
  if (!touch.by_plane || meshes.margins.rest == 0.0 || touch.is_behind) return true;
  const RelativePose& at = contact.motion.to;
  const NearestPoints nearest = meshes.NearestAt(touch.nodes, at);
  return nearest.Distance() >= std::min(meshes.margins.rest, touch.distance) - kRounding ||
         !InCone(meshes, touch.nodes, nearest, DirectionAt(meshes, touch.nodes, nearest, at), at);
}

/// Returns the candidate's motion in the frame of a body.
const ShapeMotion& MotionIn(MeshContact& contact, const NodesOfPair& nodes) {
  auto& in_body = contact.scratch.in_body[static_cast<std::size_t>(nodes.placed)];
  if (in_body.certified != contact.scratch.certified) {
    in_body.certified = contact.scratch.certified;
    const Placement X_SB = contact.meshes.FrameOf(nodes).Inverse();
    in_body.motion = {X_SB * contact.motion.from, X_SB * contact.motion.to};
  }
  return in_body.motion;
}

/// Begins the search for a plane of a patch, or of a triangle of a ball.
void BeginSearch(MeshContact& contact, Index k) {
  const MeshPair& meshes = contact.meshes;
  const NodesOfPair nodes = contact.near.Nodes(k);
  const int lane =
      contact.scratch.searches.Begin(meshes.PatchesOf(nodes), MotionIn(contact, nodes),
                                     meshes.FrameOf(nodes).R.transpose() * contact.near.Normal(k));
  contact.scratch.searched[lane] = k;
}

/// Returns whether two triangles are separate at the candidate, by any plane beside the front's; a
/// ball has searched for one before, if its touch has none.  If not, they are listed as open.
bool ExamineTriangles(MeshContact& contact, Index k, Until until) {
  const NearPairs::Pair& pair = contact.near[k];
  const double free = contact.meshes.margins.free;
  const bool has_plane = pair.touch >= 0 && contact.TouchOf(k).plane.of != ContactPlane::Of::kNone;
  if (!has_plane && !contact.meshes.IsBall()) {
    const Vec3 n = contact.near.Normal(k);
    const NodesOfPair nodes = contact.near.Nodes(k);
    const double high = contact.meshes.High(nodes, n);
    const auto above = [&](const RelativePose& at) {
      return contact.meshes.Low(nodes.a, n, at) - high;
    };
    const double after = above(contact.motion.to);
    const double before = after >= free ? above(contact.motion.from) : after;
    if (std::min(before, after) >= free) {
      contact.near.SetPlanes(k, n, before, n, after);
      return true;
    }
  }
  if (pair.touch < 0 && !contact.HasRoomForTouch()) return false;
  ++contact.queries.tested;
  if (TrianglesApart(contact, k) && MayRestApart(contact, k)) return true;
  if (!contact.motion.moves || until == Until::kFirst) return false;
  Touch& touch = contact.TouchOf(k);
  if (touch.in_cone && touch.plane.of == ContactPlane::Of::kNone) {
    touch.plane = ChoosePlane(contact.meshes, touch, contact.motion);
  }
  contact.open.push_back(k);
  contact.scratch.opened_at = contact.queries.tested;
  return false;
}

/// A pair whose plane does not hold at the candidate.  Returns false if it is not separate; its
/// search may only begin here.
bool Examine(MeshContact& contact, Index k, Until until) {
  NearPairs::Pair& pair = contact.near[k];
  pair.examined_in = contact.candidate;
  // A ball's row follows the smooth surface and not the pair's plane, so any plane will do.
  const bool any_plane = contact.meshes.IsBall() &&
                         (pair.touch < 0 || contact.TouchOf(k).plane.of == ContactPlane::Of::kNone);
  if (contact.near.Nodes(k).AreTriangles() && !any_plane)
    return ExamineTriangles(contact, k, until);
  BeginSearch(contact, k);
  return true;
}

/// Takes the result of a search.  Patches that no plane separates are split, and their children
/// decide.
bool EndSearch(MeshContact& contact, int lane, Until until) {
  const Index k = contact.scratch.searched[lane];
  const SeparatingPlane& plane = contact.scratch.searches.plane(lane);
  contact.queries.tested += plane.tries;
  if (contact.scratch.searches.Found(lane)) {
    const Vec3 n = contact.meshes.FrameOf(contact.near.Nodes(k)).R * plane.n;
    contact.near.SetPlanes(k, n, plane.before, n, plane.after);
    return true;
  }
  if (contact.near.Nodes(k).AreTriangles()) return ExamineTriangles(contact, k, until);
  return contact.near.Split(k, contact.queries);
}

}  // namespace

int Certify(MeshContact& contact, const Vec3& v, const Vec3& phi, Until until) noexcept {
  contact.motion = Motion(contact.motion.from, v, phi);
  const bool moves = contact.motion.moves;
  NearPairs& near = contact.near;
  Queries& queries = contact.queries;
  const double angle = phi.norm(), free = contact.meshes.margins.free;
  // The rotation's second order is at most 1/2 |phi|^2 of a point's lever.
  const double bend = 0.5 * angle * angle * contact.meshes.Reach();
  near.Cover(v.norm(), angle, queries);
  const PlaneMotion motion{{v.x(), v.y(), v.z(), phi.x(), phi.y(), phi.z()}, free, free + bend};
  ++contact.candidate;
  std::vector<std::int64_t>& doubts = contact.scratch.doubts;
  doubts.clear();
  contact.open.clear();
  // Pairs without room are not known to be separate.
  int apart_not = near.is_full() ? 1 : 0;
  const auto ends = [&] {
    if (queries.AreSpent()) return true;
    if (!moves || apart_not == 0) return false;
    return until == Until::kFirst || apart_not >= kEnough ||
           (!contact.open.empty() && queries.tested - contact.scratch.opened_at > kPatience);
  };
  PlaneSearches& searches = contact.scratch.searches;
  searches.Reset(free);
  ++contact.scratch.certified;
  for (Index collected = 0;;) {
    // Finds the pairs whose planes do not hold throughout the candidate, including those added by
    // splits.
    if (collected < near.size()) {
      const auto found = near.FindUsedUp(collected, motion, queries);
      collected = near.size();
      // Those that the queries do not pay for are not examined: sorting them would only take time,
      // and a shorter candidate has fewer.
      const auto count = static_cast<std::int64_t>(found.size());
      const std::int64_t price = until == Until::kFirst ? count : 1;
      if (count > 0 && queries.Spent() + price > queries.most) {
        return apart_not + static_cast<int>(found.size() + doubts.size());
      }
      const bool is_first = doubts.empty();
      for (const Index k : found) {
        doubts.push_back(DoubtOf(near.Left(k), k, near.room()));
        if (!is_first) std::push_heap(doubts.begin(), doubts.end(), std::greater<>());
      }
      for (std::size_t i = doubts.size() / 2; is_first && i-- > 0;) Sink(doubts, i, doubts[i]);
    }
    // The deepest first.
    while (!doubts.empty() && !searches.IsFull() && !ends()) {
      const Index k = NearOf(PopLeast(doubts), near.room());
      if (!Examine(contact, k, until)) ++apart_not;
    }
    if (ends() || searches.running() == 0) {
      return apart_not + static_cast<int>(doubts.size()) + std::popcount(searches.running());
    }
    for (std::uint32_t ended = searches.Try(*contact.meshes.kernels); ended != 0;
         ended &= ended - 1) {
      if (!EndSearch(contact, std::countr_zero(ended), until)) ++apart_not;
    }
  }
}

}  // namespace palpate
