#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "scenes/grid/cut_field.h"

namespace palpate {

/// A block of a solid's grid as a field had it: one that burs were at.
struct CutBlock {
  std::uint32_t solid;   ///< of HapticModel::solids()
  std::uint32_t block;   ///< of its lattice
  std::uint32_t period;  ///< how often the loop had been told to be whole
  std::int32_t entry;    ///< SparseField::kAbove: all of it is gone; else `points` tells
  std::uint64_t number;  ///< given to a loop: counts those, from 1
  /// Told by a loop: before the step of this pose, and from that of `held_from` on, it had blocks
  /// to tell and no room.  0: it had.
  std::uint64_t pose_sequence, held_from;
  std::array<float, SparseField::kPoints> points;

  /// What is to be merged.
  const float* merged() const { return entry >= 0 ? points.data() : nullptr; }
};

/// Blocks that others' burs had changed, which a loop merged before a pose and those after it.
struct CutMerge {
  std::uint64_t pose_sequence;  ///< of the first
  std::uint64_t number;         ///< CutBlock::number of the first
  std::uint32_t count;
};

/// A block as a field has it; solid, period, number and pose are left alone.  Real-time.
void CopyBlock(const SparseField& field, std::size_t block, CutBlock& copy) noexcept;

/// The block that has waited longest to be told, of the first solid that has any; its period is
/// left alone.  False where there is none.  Real-time.
bool TakeChanged(std::span<CutField> cuts, CutBlock& told) noexcept;

}  // namespace palpate
