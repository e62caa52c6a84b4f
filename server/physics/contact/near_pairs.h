#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "server/physics/contact/touch.h"
#include "server/physics/limits.h"
#include "server/physics/simd/aligned_columns.h"
#include "server/physics/simd/kernels.h"
#include "server/physics/surface/separation_front.h"

namespace palpate {

/// The cost of a sub-step, in queries (StepTuning::queries): a count, not a time.
struct Queries {
  std::int64_t most = 0;
  std::int64_t tested = 0;     ///< directions tried, and nearest points of triangles computed
  std::int64_t refreshed = 0;  ///< pairs refreshed, or found in doubt

  std::int64_t Spent() const { return tested + refreshed / limits::mesh::kRefreshesAQuery; }
  bool AreSpent() const { return Spent() >= most; }
};

/// The pairs of a front that a sub-step could bring together.  Each has a plane that holds at the
/// beginning of the sub-step, and the plane that a candidate found for its end.
/// Real-time except for construction: no allocation, lock, log or clock.  Deterministic.
class NearPairs {
 public:
  using Index = std::int32_t;
  struct Pair {
    SeparationFront::Index in_front;
    Index touch = -1;              ///< -1 if it has none
    std::int32_t examined_in = 0;  ///< the last candidate at which it was examined closely
    bool split = false;            ///< its children are examined in its place
    bool replaced = false;         ///< its plane is no longer the front's
  };

  /// @param queries  most queries of a sub-step
  explicit NearPairs(int queries);

  /// Begins a sub-step at `from`, without pairs.  Restarts the front if the tool was
  /// set to another place.
  void Begin(const MeshPair& meshes, SeparationFront& front, const RelativePose& from);
  /// Gathers the pairs that a motion of this length [m, rad] could bring together.  Called once a
  /// candidate's length is known, because it is mostly far shorter than the sub-step may be.
  void Cover(double translation, double rotation, Queries& queries);
  /// The largest possible number of pairs: a power of two.
  std::int64_t room() const { return static_cast<std::int64_t>(after_.size()); }
  /// True if more pairs are near than may be refreshed; then no candidate of the sub-step is free.
  bool is_full() const { return full_; }

  Index size() const { return static_cast<Index>(pairs_.size()); }
  Pair& operator[](Index k) { return pairs_[static_cast<std::size_t>(k)]; }
  const Pair& operator[](Index k) const { return pairs_[static_cast<std::size_t>(k)]; }
  NodesOfPair Nodes(Index k) const { return meshes_->NodesOf(front_->pair((*this)[k].in_front)); }
  /// Returns those pairs, from `first` on, whose planes do not hold throughout a motion.  Valid
  /// until the next call.
  std::span<const Index> FindUsedUp(Index first, const PlaneMotion& motion, Queries& queries);
  /// Lower bound on the gap that a pair has left along its plane, from the last FindUsedUp [m].
  double Left(Index k) const { return planes_.left[k]; }

  /// The normal of a pair's plane at the beginning of the sub-step.
  Vec3 Normal(Index k) const {
    return {planes_.along[0][k], planes_.along[1][k], planes_.along[2][k]};
  }
  /// Sets the planes that separate a pair in the candidate: (n_before, before) at its beginning,
  /// (n_after, after) at its end.
  void SetPlanes(Index k, const Vec3& n_before, double before, const Vec3& n_after, double after);
  /// Replaces a pair of patches by its children, which are appended; replaces a pair of a block's
  /// node by one with the block's body.  Returns false if there is no room.
  bool Split(Index k, Queries& queries);

  /// Ends the sub-step.  The front takes over the planes: those of the motion's end if
  /// it moves and candidate number `candidate` examined the pair closely.
  void Accept(const Motion& motion, std::int32_t candidate);
  /// Merges pairs of the front that one plane separates as a whole, with some room.  The planes
  /// that separate the two children are tried.  If neither holds, the pair is tried again when the
  /// tool has gone as far as the better one lacks, because no gap changes faster.
  void Merge(const RelativePose& at, Queries& queries);

 private:
  struct Plane {
    Vec3 n;
    double slack;
  };
  void Add(SeparationFront::Index in_front);
  void Add(const SeparationFront::Index* in_front, int count, double path, Queries& queries);
  void AddChild(SeparationFront::Index in_front, double radius, const Vec3& n, double slack);
  void SetPlane(Index k, const Vec3& n, double slack);
  void Close(Index k);
  bool Enter(Index k, std::int32_t block, Queries& queries);

  const MeshPair* meshes_ = nullptr;  ///< set during a sub-step only, as is front_
  SeparationFront* front_ = nullptr;
  RelativePose from_{Vec3::Zero(), Quat::Identity()};
  bool full_ = false;
  double covered_ = 0.0;  ///< path of A for which all near pairs are listed [m]
  std::uint32_t substep_ = 0;
  std::vector<std::uint32_t> seen_;  ///< for each slot of the front: the sub-step in
                                     ///< which it is near
  std::vector<Plane> after_;  ///< for each possible pair: its plane at the end of the candidate
  std::vector<Pair> pairs_;
  AlignedColumns storage_;
  PlaneColumns planes_{};  ///< for each pair, at the beginning
  std::vector<std::int32_t> found_;
};

}  // namespace palpate
