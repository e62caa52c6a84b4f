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
#include "server/physics/surface/tool_pose.h"

namespace palpate {

/// Planes that show a tool and bodies apart, kept from step to step.  The pairs of nodes of the
/// tool's tree and a body's form a tree themselves: a pair's children are those in which the larger
/// of its nodes is split.  The front is a cut through those trees, one for each body: every pair of
/// triangles lies below exactly one pair of the front, and each of these has a plane and a slack
/// (Ehmann & Lin, Computer Graphics Forum 20 (2001) 500-510).
///
/// No slack falls by more than the way of the tool's farthest point.  So a pair need not be looked
/// at before that way has grown by its slack: its expiry.  Refresh then tells what is really left.
///
/// A value: copied, it goes on alike.  Real-time: once Reserve has been called, nothing allocates.
class SeparationFront {
 public:
  using Index = std::int32_t;
  /// A pair of nodes.
  struct Pair {
    HullTree::Node tool, object;
    std::int32_t body;
    Index parent, child;  ///< child: the first of two; -1 where the pair is of the front
  };
  struct Epoch {
    Vec3 p = Vec3::Zero();
    Quat q = Quat::Identity();
    Mat3 R = Mat3::Identity();
    double turned = 0.0;  ///< sum of the rotations before it [rad]
  };

  static constexpr std::size_t kMaxSlots = 1 << 17;
  /// Room for the most pairs that a front can have.
  void Reserve();
  bool empty() const { return pairs_.empty(); }
  /// Places for pairs: of the front, open ones above it, and unused ones.
  std::size_t slots() const { return pairs_.size(); }
  /// Pairs of the front: a root for each body, and one more with each that is opened.
  std::size_t size() const {
    return static_cast<std::size_t>(roots_) + (slots() - RootSlots()) / 2 - unused_.size();
  }

  /// Nothing is known: it is to be restarted.
  void Clear() { pairs_.clear(); }
  /// The pair of roots of each body, not known to be apart, for the tool at `at`.
  /// `for_solids`: what of the tool solids are felt by, of bodies whose trees are of blocks.
  void Restart(const ContactBody& tool, std::span<const ContactBody> bodies, const ToolPose& at,
               std::optional<HullTree::Node> for_solids = std::nullopt);
  /// The tool has gone to `at`.  `reach`: of its farthest point from the reference point [m].
  /// Returns the way of that point at most [m].
  double Move(const ToolPose& at, double reach);

  const Pair& pair(Index i) const { return pairs_[static_cast<std::size_t>(i)]; }
  /// Its plane, and the slack that it had at the pose where that was set or refreshed last; not
  /// positive: no plane is known.  Of an open pair, `slack` is the way from which on a merge may be
  /// tried.
  const PlaneRecord& plane(Index i) const { return planes_[static_cast<std::size_t>(i)]; }
  Vec3 Normal(Index i) const { return Vec3::Map(plane(i).n); }
  /// Way at which each slot's plane may be used up; infinite for pairs that are open or unused.
  const double* expiry() const { return expiry_.empty() ? nullptr : expiry_[0].v; }
  /// Way of the tool's farthest point so far [m]: what `expiry` is compared with.
  double way() const { return way_; }
  const Epoch& now() const { return epochs_[epoch_ % kPlaneEpochs]; }
  /// Whether the pose at which a pair's slack was known last is still kept.  If not, it is to be
  /// set before it can be refreshed.
  bool IsKept(Index i) const {
    return epoch_ - epoch_of_[static_cast<std::size_t>(i)] < kPlaneEpochs;
  }
  /// Brings the planes of `count` pairs up to the pose of now, and gives them as columns from
  /// `first` on.  The slack is what each has at least, by how its node has moved.
  void Refresh(const Kernels& kernels, const Index* slots, int count, int first,
               const PlaneColumns& out);
  /// Sets a pair's plane, at the pose of now.
  void Set(Index i, const Vec3& n, double slack);
  /// Opens a pair of the front: its children take the plane that it has at the pose of now.  -1
  /// where there is no room.
  /// `body`: the pair's.
  Index Split(Index i, const HullTree& tool, const HullTree& body, const Vec3& n, double slack);
  /// A pair of a block's node goes on as one of that block's own body, and with its root; it keeps
  /// its plane.  Where the block holds nothing it is apart for good.
  void Enter(Index i, std::int32_t body, std::optional<HullTree::Node> root);
  /// Calls visit(index, pair) for the pairs that entered blocks, bodies from `first` on.
  template <class Visit>
  void ForEachEntry(std::int32_t first, Visit visit) const {
    for (Index i = 0; static_cast<std::size_t>(i) < pairs_.size(); ++i) {
      const Pair& of = pair(i);
      if (of.body < first || (of.parent < 0 && i >= roots_)) continue;
      if (of.parent < 0 || pair(of.parent).body != of.body) visit(i, of);
    }
  }
  /// Closes those for which leaves(pair, outside) is true, which sets the body and the node that
  /// they had before: they are not known to be apart.
  template <class Leaves>
  void CloseEntries(std::int32_t first, Leaves leaves) {
    ForEachEntry(first, [&](Index i, const Pair& of) {
      Pair outside = of;
      if (!leaves(of, outside)) return;
      CloseBelow(i);
      pairs_[static_cast<std::size_t>(i)].body = outside.body;
      pairs_[static_cast<std::size_t>(i)].object = outside.object;
      Set(i, Normal(i), -1.0);
    });
  }
  /// Closes a pair whose children are of the front; it has the plane (n, slack).
  void Merge(Index i, const Vec3& n, double slack);
  /// Whether a pair is open and its children are both of the front.
  bool IsMergeable(Index i) const {
    const Index child = pair(i).child;
    return child >= 0 && pair(child).child < 0 && pair(child + 1).child < 0;
  }
  /// The next pair for which that is so and which RetryAfter does not put off; the calls go round
  /// all of them.  -1 at the end of a round, or where the next few dozen places hold none.
  Index NextMergeable();
  /// An open pair is not to be tried again before the way has grown by this [m].
  void RetryAfter(Index i, double way) {
    planes_[static_cast<std::size_t>(i)].slack = way_ + way;
    SetGate(i);
  }

  struct alignas(64) Eight {
    double v[8];
  };

 private:
  double& ExpiryOf(Index i) {
    return expiry_[static_cast<std::size_t>(i) / 8].v[static_cast<std::size_t>(i) % 8];
  }

  double& GateOf(Index child) { return gate_[static_cast<std::size_t>(child) / 2]; }
  /// Of an open pair.
  void SetGate(Index i) {
    GateOf(pair(i).child) =
        IsMergeable(i) ? plane(i).slack : std::numeric_limits<double>::infinity();
  }
  std::size_t RootSlots() const { return (static_cast<std::size_t>(roots_) + 1) & ~std::size_t{1}; }
  void Put(Index i, const HullTree& tool, const Pair& pair);
  void CloseBelow(Index i);

  std::vector<Pair> pairs_;  ///< roots first, in the bodies' order; then siblings beside each
                             ///< other, from an even index on
  std::vector<PlaneRecord> planes_;      ///< of each pair
  std::vector<std::uint32_t> epoch_of_;  ///< of each pair's slack
  std::vector<Eight> expiry_;            ///< infinite for pairs that are open or unused
  /// Of each two siblings: the way from which on NextMergeable gives their parent; infinite where
  /// they are not both of the front.  Beside each other, because it goes past most of them.
  std::vector<double> gate_;
  std::vector<Index> unused_;  ///< first of two
  std::array<Epoch, kPlaneEpochs> epochs_;
  std::array<EpochMotion, kPlaneEpochs> since_;  ///< from each epoch until now
  std::uint32_t epoch_ = 0;
  Index roots_ = 0;
  double way_ = 0.0;
  Index next_merged_ = 0;
};

}  // namespace palpate
