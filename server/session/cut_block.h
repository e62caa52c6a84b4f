#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "scenes/grid/cut_field.h"

namespace palpate {

/// A copy of a block of a solid's grid that burs have changed.
struct CutBlock {
  std::uint32_t solid;   ///< index into HapticModel::solids()
  std::uint32_t block;   ///< index into its lattice
  std::uint32_t period;  ///< how often the loop had been told to make the scene whole
  std::int32_t entry;    ///< SparseField::kAbove: all of it is gone; otherwise see `points`
  std::uint64_t number;  ///< for a block given to a loop: counts these, from 1
  /// For a block told by a loop: `pose_sequence` is the pose before whose step it was told;
  /// `held_from` is the pose since whose step the loop had blocks to tell but no room, or 0
  /// if it had room.
  std::uint64_t pose_sequence, held_from;
  std::array<float, SparseField::kPoints> points;

  /// Returns the points to merge; null if all of the block is gone.
  const float* merged() const { return entry >= 0 ? points.data() : nullptr; }
};

/// Blocks changed by other sessions' burs, which a loop merges before a pose and the ones after it.
struct CutMerge {
  std::uint64_t pose_sequence;  ///< of the first pose
  std::uint64_t number;         ///< CutBlock::number of the first block
  std::uint32_t count;
};

/// Copies a block of a field; leaves solid, period, number and pose unchanged.  Real-time.
void CopyBlock(const SparseField& field, std::size_t block, CutBlock& copy) noexcept;

/// Takes the block that has waited longest to be told, from the first solid that has one; leaves
/// its period unchanged.  Returns false if there is none.  Real-time.
bool TakeChanged(std::span<CutField> cuts, CutBlock& published) noexcept;

}  // namespace palpate
