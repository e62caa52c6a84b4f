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

/// What a sub-step may cost, in looks (StepTuning::looks): a count and not a clock.
struct Looks {
  std::int64_t most = 0;
  std::int64_t tested = 0;     ///< directions looked along, and nearest points of triangles
  std::int64_t refreshed = 0;  ///< pairs brought up to date or found in doubt

  std::int64_t Spent() const { return tested + refreshed / limits::mesh::kRefreshesALook; }
  bool AreSpent() const { return Spent() >= most; }
};

/// The pairs of a front that a sub-step could bring together, each with a plane that holds where
/// the sub-step begins; and what a trial found to be their planes at its end.
/// Real-time but for construction: no allocation, lock, log or clock.  Deterministic.
class NearPairs {
 public:
  using Index = std::int32_t;
  struct Pair {
    NodesOfPair nodes;
    SeparationFront::Index in_front;
    Index touch = -1;            ///< -1: none
    std::int32_t looked_at = 0;  ///< closely, at this trial
    bool split = false;          ///< its parts are looked at in its place
    bool replaced = false;       ///< its plane is not the front's any more
  };

  /// @param looks  of a sub-step at most.
  explicit NearPairs(int looks);

  /// Begins a sub-step at `from`, without pairs.  A front whose tool has been set to another place
  /// begins anew.
  void Begin(const ToolAndBodies& meshes, SeparationFront& front, const ToolPose& from);
  /// Gathers the pairs that a motion of such a length [m, rad] could bring together: once it is
  /// known, for a trial is mostly far shorter than the sub-step may be.
  void Cover(double translation, double rotation, Looks& looks);
  /// Most pairs that there can be: a power of two.
  std::int64_t room() const { return static_cast<std::int64_t>(after_.size()); }
  /// More pairs are near than may be brought up to date: none of the sub-step's trials is free.
  bool is_full() const { return full_; }

  Index size() const { return static_cast<Index>(pairs_.size()); }
  Pair& operator[](Index k) { return pairs_[static_cast<std::size_t>(k)]; }
  const Pair& operator[](Index k) const { return pairs_[static_cast<std::size_t>(k)]; }
  /// Of the pairs from `first` on: those whose planes do not hold throughout a motion.  Until the
  /// next call.
  std::span<const Index> FindUsedUp(Index first, const PlaneMotion& motion, Looks& looks);
  /// Gap left to a pair along its plane at least, by the last FindUsedUp [m].
  double Left(Index k) const { return planes_.left[k]; }

  /// A pair's plane where the sub-step begins.
  Vec3 Normal(Index k) const {
    return {planes_.along[0][k], planes_.along[1][k], planes_.along[2][k]};
  }
  /// Sets the plane that keeps a pair apart during the trial: (n_before, before) at its beginning,
  /// (n_after, after) at its end.
  void SetPlanes(Index k, const Vec3& n_before, double before, const Vec3& n_after, double after);
  /// Replaces a pair of patches by its parts, which are added at the end; a pair of a block, by
  /// that of what is in it.  False where there is no room.
  bool Split(Index k, Looks& looks);

  /// Ends the sub-step: the front takes the planes, those of the motion's end where it moves and
  /// the trial of number `trial` looked closely.  Then pairs that one plane keeps apart are merged.
  void Accept(const Motion& motion, std::int32_t trial, Looks& looks);

 private:
  struct Plane {
    Vec3 n;
    double slack;
  };
  void Add(SeparationFront::Index in_front);
  void Add(const SeparationFront::Index* in_front, int count, double way, Looks& looks);
  void AddPart(SeparationFront::Index in_front, double radius, const Vec3& n, double slack);
  void SetPlane(Index k, const Vec3& n, double slack);
  void Close(Index k);
  void Merge(const ToolPose& at, Looks& looks);
  bool Enter(Index k, std::int32_t block, Looks& looks);

  const ToolAndBodies* meshes_ = nullptr;  ///< during a sub-step, as the front
  SeparationFront* front_ = nullptr;
  ToolPose from_{Vec3::Zero(), Quat::Identity()};
  bool full_ = false;
  double covered_ = 0.0;  ///< way for which all pairs are here [m]
  std::uint32_t substep_ = 0;
  std::vector<std::uint32_t> seen_;  ///< of each of the front's slots: the sub-step it is near in
  std::vector<Plane> after_;         ///< of each pair that there may be, at the trial's end
  std::vector<Pair> pairs_;
  AlignedColumns storage_;
  PlaneColumns planes_{};  ///< of each pair, at the beginning
  std::vector<std::int32_t> found_;
};

}  // namespace palpate
