#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "common/math/pose.h"
#include "server/physics/simd/kernels.h"
#include "server/physics/surface/contact_bodies.h"
#include "server/physics/surface/hull_tree.h"
#include "server/physics/surface/separating_plane.h"

namespace palpate {

/// Separating planes between a body A and the bodies B, kept from step to step: a cut through the
/// tree of pairs of nodes.  All in the frame of B, so it counts only how A moves against B.
/// README.md has the idea, and what slack, expiry and merges are. A value: a copy behaves alike.
/// Real-time: nothing allocates after Reserve.
class SeparationFront {
 public:
  using Index = std::int32_t;
  /// A pair of nodes.
  struct Pair {
    HullTree::Node a, b;
    std::int32_t body;
    Index parent, child;  ///< child: the first of two; -1 if the pair is in the front
  };
  struct Epoch {
    Vec3 p = Vec3::Zero();
    Quat q = Quat::Identity();
    Mat3 R = Mat3::Identity();
  };

  static constexpr std::size_t kMaxSlots = 1 << 17;
  /// Allocates room for the largest front.
  void Reserve();
  bool empty() const { return pairs_.empty(); }
  /// Number of places for pairs: those of the front, open ones above it, and unused ones.
  std::size_t slots() const { return pairs_.size(); }
  /// Number of pairs in the front: one root for each body, and one more for each
  /// pair that is split.
  std::size_t size() const {
    return static_cast<std::size_t>(roots_) + (slots() - RootSlots()) / 2 - unused_.size();
  }

  /// Forgets everything; Restart must follow.
  void Clear() { pairs_.clear(); }
  /// Starts again with the pair of roots of each body of the frame B, for A at `at`, with no plane
  /// known.  The front keeps apart from those of other frames for good: other fronts hold them.
  /// `for_solids`: the part of A that meets bodies whose trees are of blocks.
  void Restart(const MovingBody& a, std::span<const ContactBody> bodies, const RelativePose& at,
               std::optional<HullTree::Node> for_solids = std::nullopt, std::int32_t frame = 0);
  /// Moves A to `at`.  `reach`: distance of its farthest point from the reference point [m].
  /// Returns an upper bound on the path of that point [m].
  double Move(const RelativePose& at, double reach);

  const Pair& pair(Index i) const { return pairs_[static_cast<std::size_t>(i)]; }
  /// The plane of a pair, with the slack that it had when last set or refreshed; if the slack is
  /// not positive, no plane is known.  For an open pair, `slack` is the path from which on a
  /// merge may be tried.
  const PlaneRecord& plane(Index i) const { return planes_[static_cast<std::size_t>(i)]; }
  Vec3 Normal(Index i) const { return Vec3::Map(plane(i).n); }
  /// For each slot, the path at which its plane may be used up; infinite for pairs that
  /// are open or unused.
  const double* expiry() const { return expiry_.empty() ? nullptr : expiry_[0].v; }
  /// Path of A's farthest point so far [m], to compare with `expiry`.
  double path() const { return path_; }
  const Epoch& now() const { return epochs_[epoch_ % kPlaneEpochs]; }
  /// Returns whether the pose at which a pair's slack was last known is still stored.  If not, the
  /// pair must be set before it can be refreshed.
  bool IsKept(Index i) const {
    return epoch_ - epoch_of_[static_cast<std::size_t>(i)] < kPlaneEpochs;
  }
  /// Updates the planes of `count` pairs to the current pose, and writes them as columns from
  /// `first` on.  Each slack becomes a lower bound, from the motion of the pair's node.
  void Refresh(const Kernels& kernels, const Index* slots, int count, int first,
               const PlaneColumns& out);
  /// Sets a pair's plane at the current pose.
  void Set(Index i, const Vec3& n, double slack);
  /// Lets a pair not be near before A has gone as far as it surely has left [m].
  void Expire(Index i, double left) { ExpiryOf(i) = path_ + left; }
  /// Splits a pair of the front: its children take the given plane, at the current pose.  Returns
  /// the first child, or -1 if there is no room.
  Index Split(Index i, const HullTree& tree_a, const HullTree& tree_b, const Vec3& n, double slack);
  /// Replaces the body of a pair that has reached a block's node by the block's own body,
  /// from `root` on; the pair keeps its plane.  If the block is empty (no root), the pair
  /// is separate for good.
  void Enter(Index i, std::int32_t body, std::optional<HullTree::Node> root);
  /// Calls visit(index, pair) for each pair at which the front entered a block, with a body
  /// number from `first` on.
  template <class Visit>
  void ForEachEntry(std::int32_t first, Visit visit) const {
    for (Index i = 0; static_cast<std::size_t>(i) < pairs_.size(); ++i) {
      const Pair& of = pair(i);
      if (of.body < first || (of.parent < 0 && i >= roots_)) continue;
      if (of.parent < 0 || pair(of.parent).body != of.body) visit(i, of);
    }
  }
  /// Closes each such pair for which leaves(pair, outside) returns true; `leaves` sets the body and
  /// node that the pair had before.  The pair is then not known to be separate.
  template <class Leaves>
  void CloseEntries(std::int32_t first, Leaves leaves) {
    ForEachEntry(first, [&](Index i, const Pair& of) {
      Pair outside = of;
      if (!leaves(of, outside)) return;
      CloseBelow(i);
      pairs_[static_cast<std::size_t>(i)].body = outside.body;
      pairs_[static_cast<std::size_t>(i)].b = outside.b;
      Set(i, Normal(i), -1.0);
    });
  }
  /// Merges the children of a pair, which are both in the front, into it; the pair gets
  /// the plane (n, slack).
  void Merge(Index i, const Vec3& n, double slack);
  /// Returns whether a pair is open and both its children are in the front.
  bool IsMergeable(Index i) const {
    const Index child = pair(i).child;
    return child >= 0 && pair(child).child < 0 && pair(child + 1).child < 0;
  }
  /// Returns the next mergeable pair that RetryAfter does not put off, in turn; -1 at the end of a
  /// round, or if the next few dozen places hold none.
  Index NextMergeable();
  /// Lets an open pair not be tried again before the path has grown by this [m].
  void RetryAfter(Index i, double path) {
    planes_[static_cast<std::size_t>(i)].slack = path_ + path;
    SetGate(i);
  }

  struct alignas(64) Eight {
    double v[8];
  };

  /// Calls visit(member) for each member, to store them or to take them from what was stored; then
  /// IsSound says whether they may be used.
  template <class Front, class Visit>
  static void ForEachMember(Front& front, Visit visit) {
    visit(front.pairs_);
    visit(front.planes_);
    visit(front.epoch_of_);
    visit(front.expiry_);
    visit(front.gate_);
    visit(front.unused_);
    for (auto& epoch : front.epochs_) {
      visit(epoch.p);
      visit(epoch.q.coeffs());
      visit(epoch.R);
    }
    for (auto& motion : front.since_) visit(motion);
    visit(front.epoch_);
    visit(front.roots_);
    visit(front.path_);
    visit(front.next_merged_);
  }
  /// Returns whether the pairs are a forest of nodes that there are, with one root for each body,
  /// as every sequence of calls leaves them.  For a scene without solids.  Not real-time.
  bool IsSound(const MovingBody& a, std::span<const ContactBody> b) const;

 private:
  double& ExpiryOf(Index i) {
    return expiry_[static_cast<std::size_t>(i) / 8].v[static_cast<std::size_t>(i) % 8];
  }

  double& GateOf(Index child) { return gate_[static_cast<std::size_t>(child) / 2]; }
  /// For an open pair.
  void SetGate(Index i) {
    GateOf(pair(i).child) =
        IsMergeable(i) ? plane(i).slack : std::numeric_limits<double>::infinity();
  }
  std::size_t RootSlots() const { return (static_cast<std::size_t>(roots_) + 1) & ~std::size_t{1}; }
  void Put(Index i, const HullTree& tree_a, const Pair& pair);
  void CloseBelow(Index i);

  std::vector<Pair> pairs_;  ///< roots first, in the bodies' order; then siblings beside each
                             ///< other, from an even index on
  std::vector<PlaneRecord> planes_;      ///< for each pair
  std::vector<std::uint32_t> epoch_of_;  ///< for each pair: the epoch of its slack
  std::vector<Eight> expiry_;            ///< infinite for pairs that are open or unused
  /// For each two siblings, the path from which on NextMergeable returns their parent; infinite if
  /// not both are in the front.  In an array of its own, because the search skips most of them.
  std::vector<double> gate_;
  std::vector<Index> unused_;  ///< the first of each two
  std::array<Epoch, kPlaneEpochs> epochs_;
  std::array<EpochMotion, kPlaneEpochs> since_;  ///< from each epoch until now
  std::uint32_t epoch_ = 0;
  Index roots_ = 0;
  double path_ = 0.0;
  Index next_merged_ = 0;
};

}  // namespace palpate
