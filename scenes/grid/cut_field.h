#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "scenes/grid/bur.h"
#include "scenes/grid/solid_grid.h"
#include "scenes/grid/sparse_field.h"

namespace palpate {

class BurSweep;

/// What one step of a bur did.
struct CutAway {
  /// The field has no storage left for the place: nothing was removed.
  bool full = false;
  /// What it cost: rows of eight points that were compared with a ball's way, some 50 ns each; of
  /// another bur a row counts as three.
  int looks = 0;
};

/// What burs took away of a solid: its own signed distance, phi_c, above 0 where a bur was.  What
/// is left is where both this and the solid's, phi_0, are below 0:
///
///     phi = max(phi_0, phi_c).
///
/// The two are kept apart, and each is interpolated before the greater is taken: interpolating the
/// greater would round the rim where a cut meets the old surface, and a bur's samples there would
/// find free what is not.  phi_c falls short of the truth by what a chord of a sphere does, h^2 /
/// 6R on average: a bur of convex shape never frees what it did not reach.
///
/// Real-time but for the constructor: no allocation, lock or clock.
class CutField {
 public:
  /// `solid` outlives this; `most_bytes` is what this may take; `name` is for what is thrown;
  /// `blocks`: of storage; 0: as many as the solid has, with which no cut can find it full. Throws
  /// Error, before it takes its memory, where that is more than it may.
  CutField(const SolidGrid& solid, std::size_t most_bytes, const std::string& name,
           std::size_t blocks = 0);

  const SolidGrid& solid() const { return *solid_; }
  const SparseField& field() const { return field_; }

  /// What is left, at a point of B.
  FieldSample Sample(const Vec3& p_B) const noexcept;
  double Distance(const Vec3& p_B) const noexcept {
    const Lattice::Place at = field_.lattice().PlaceOf(p_B);
    return std::max(solid_->field().Distance(at), field_.Distance(at));
  }

  /// phi_c <- max(phi_c, -(distance to the bur's way)).  Equal whatever the order of the blocks,
  /// and of steps: the greatest of all.
  /// `X_BT`: where the bur is before the step; `step_B`: how far it goes, straight and
  /// without turning [m].
  CutAway Remove(const Bur& bur, const Pose& X_BT, const Vec3& step_B) noexcept;

  /// phi_c <- max(phi_c, points) at the points of a block: what another field of the solid has
  /// there; null: all of it is gone.  True where any rose.  Fields that have merged all blocks of
  /// each other hold the same bits, in whatever order and however often.  TakeChanged does not give
  /// what came so.
  /// Right where the storage is for all of the solid.
  bool Merge(std::size_t block, const float* points) noexcept;

  /// The block, of those where Remove changed points since it was last taken here, that has waited
  /// longest.  False where there is none.
  bool TakeChanged(std::size_t& block) noexcept;
  /// How often blocks have changed, which did at one of the last kChanges times, and of each block
  /// the time when it last did; 0: never.
  static constexpr std::uint32_t kChanges = 1 << 16;
  std::uint32_t changes() const { return changes_; }
  std::size_t Changed(std::uint32_t time) const { return changed_[time % kChanges]; }
  std::uint32_t ChangedAt(std::size_t block) const { return changed_at_[block]; }
  bool has_changed() const { return waiting_count_ > 0; }
  /// All is there again, as at first, and no block has changed.  Goes through the table of blocks:
  /// some ten microseconds for a tooth.
  void MakeWhole() noexcept;

  /// Share of a point's voxel that is left, 0 to 1.  Any integers.
  double Left(int i, int j, int k) const noexcept;

  /// What is left of each material [m^3].  Tools: goes through all points.
  std::array<double, SolidGrid::kMaterials> VolumeLeft() const;

  std::size_t bytes() const;

 private:
  struct Touched {
    std::size_t block;
    int at[3];  ///< of the block
  };

  static std::size_t BytesOf(const SolidGrid& solid, std::size_t blocks);
  bool TakeStorage(const int low[3], const int high[3], const BurSweep& sweep,
                   const Pose& X_TB) noexcept;
  /// True where a point of the block rose.
  bool Raise(const Touched& touched, const BurSweep& sweep, const Pose& X_TB) noexcept;
  void ReleaseIfClear(std::size_t block) noexcept;
  /// Whatever raised a block's points: contact is to follow.
  void Note(std::size_t block) noexcept {
    changed_at_[block] = ++changes_;
    changed_[changes_ % kChanges] = static_cast<std::uint32_t>(block);
  }
  void Store(std::size_t block) noexcept;
  void Wait(std::size_t block) noexcept;
  double GoneSince(const Bur& bur, const Pose& X_BT) const noexcept;
  double ShareOf(int i, int j, int k) const noexcept;
  double UncutShareOf(int i, int j, int k) const noexcept;

  const SolidGrid* solid_;
  SparseField field_;
  /// How far the bur has gone in all steps: no point of it has gone farther [m].
  double gone_ = 0.0;
  int looks_ = 0;  ///< of the present step
  /// Of each stored row of points, up to which gone_ nothing in it can change [m].
  std::vector<double> still_;
  Bur bur_ = Bur::Ball(1.0);            ///< of the last step
  Pose end_{};                          ///< X_BT where that ended
  RoomyVector<Touched> touched_;        ///< of the present step, in the order of the table
  std::vector<std::uint32_t> waiting_;  ///< a ring of blocks that changed, each at most once
  std::vector<bool> waits_;             ///< of a block: it is in the ring
  std::size_t first_waiting_ = 0, waiting_count_ = 0;
  std::uint32_t changes_ = 0;
  std::vector<std::uint32_t> changed_at_;  ///< of a block
  std::vector<std::uint32_t> changed_;     ///< at each time, a ring
};

}  // namespace palpate
