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

/// The result of one step of a bur.
struct CutAway {
  /// The field has no storage left for this step, so nothing was removed.
  bool full = false;
  /// Cost of the step: rows of eight points that were compared with a ball's way, some 50 ns each;
  /// a row counts as three for any other bur.
  int queries = 0;
};

/// The part of a solid that burs have removed, as a signed distance phi_c of its own:
/// positive where a bur was.  What is left of the solid is where both this and the solid's
/// phi_0 are negative:
///
///     phi = max(phi_0, phi_c) < 0.
///
/// Each field is interpolated before the greater value is taken.  Interpolating the maximum would
/// round the rim where a cut meets the old surface, and samples of a bur there would find free
/// space that is still solid.  Between points phi_c is too low by as much as the chord of a sphere,
/// h^2 / 6R on average: a convex bur never removes what it did not reach.
///
/// Real-time except for the constructor: no allocation, lock or clock.
class CutField {
 public:
  /// `solid` must outlive this; `most_bytes`: the most memory that this may take; `name`: for
  /// error messages; `blocks`: number of blocks to reserve storage for; 0: as many as the
  /// solid has, which is enough for every cut.  Throws Error, before it allocates, if that
  /// needs more than `most_bytes`.
  CutField(const SolidGrid& solid, std::size_t most_bytes, const std::string& name,
           std::size_t blocks = 0);

  const SolidGrid& solid() const { return *solid_; }
  const SparseField& field() const { return field_; }

  /// Returns the distance field of what is left, at a point of B.
  FieldSample Sample(const Vec3& p_B) const noexcept;
  double Distance(const Vec3& p_B) const noexcept {
    const Lattice::Place at = field_.lattice().PlaceOf(p_B);
    return std::max(solid_->field().Distance(at), field_.Distance(at));
  }

  /// Removes what a bur sweeps in a step: phi_c <- max(phi_c, -(distance to the bur's way)).  The
  /// result does not depend on the order of blocks or steps, because it is a maximum.
  /// `X_BT`: the bur's pose before the step; `step_B`: its motion, straight and
  /// without turning [m].
  CutAway Remove(const Bur& bur, const Pose& X_BT, const Vec3& step_B) noexcept;

  /// Merges a block of another field of the same solid: phi_c <- max(phi_c, points); null: all of
  /// the block is gone.  Returns whether any value rose.  Fields that have merged all blocks of
  /// each other hold the same bits, in whatever order and however often they did.  TakeChanged does
  /// not report merged blocks.  Requires storage for all of the solid.
  bool Merge(std::size_t block, const float* points) noexcept;

  /// Takes from the queue of blocks whose points Remove changed the one that has waited longest.
  /// Returns false if the queue is empty.
  bool TakeChanged(std::size_t& block) noexcept;
  /// A log of changed blocks, in order: the number of changes so far, the block of one of the last
  /// kChanges changes, and the number of each block's last change; 0: it never changed.
  static constexpr std::uint32_t kChanges = 1 << 16;
  std::uint32_t changes() const { return changes_; }
  std::size_t Changed(std::uint32_t time) const { return changed_[time % kChanges]; }
  std::uint32_t ChangedAt(std::size_t block) const { return changed_at_[block]; }
  bool has_changed() const { return waiting_count_ > 0; }
  /// Restores the whole solid, and clears the record of changes.  Goes through the table of blocks:
  /// some ten microseconds for a tooth.
  void MakeWhole() noexcept;

  /// Returns the share of a point's voxel that is left, 0 to 1.  Takes any integers.
  double Left(int i, int j, int k) const noexcept;

  /// Returns the volume left of each material [m^3].  For tools: visits all points.
  std::array<double, SolidGrid::kMaterials> VolumeLeft() const;

  std::size_t bytes() const;

 private:
  struct Touched {
    std::size_t block;
    int at[3];  ///< its coordinates, in blocks
  };

  static std::size_t BytesOf(const SolidGrid& solid, std::size_t blocks);
  bool TakeStorage(const int low[3], const int high[3], const BurSweep& sweep,
                   const Pose& X_TB) noexcept;
  /// Returns whether any point of the block rose.
  bool Raise(const Touched& touched, const BurSweep& sweep, const Pose& X_TB) noexcept;
  void ReleaseIfClear(std::size_t block) noexcept;
  /// Records that points of the block rose, from a cut or a merge, for contact to follow.
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
  /// Bound of the distance that any point of the bur has gone in all steps [m].
  double gone_ = 0.0;
  int queries_ = 0;  ///< CutAway::queries of the present step
  /// For each stored row of points, the value of gone_ up to which no point of it can change [m].
  std::vector<double> still_;
  Bur bur_ = Bur::Ball(1.0);            ///< bur of the last step
  Pose end_{};                          ///< X_BT at its end
  RoomyVector<Touched> touched_;        ///< blocks near the present step, in the table's order
  std::vector<std::uint32_t> waiting_;  ///< a ring of changed blocks, each at most once
  std::vector<bool> waits_;             ///< for each block, whether it is in the ring
  std::size_t first_waiting_ = 0, waiting_count_ = 0;
  std::uint32_t changes_ = 0;
  std::vector<std::uint32_t> changed_at_;  ///< for each block, the number of its last change
  std::vector<std::uint32_t> changed_;     ///< the block of each change, a ring
};

}  // namespace palpate
