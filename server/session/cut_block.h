#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "scenes/grid/cut_field.h"

namespace palpate {

/// A block of a solid's grid that a loop's bur was at, as it stood then.
struct CutBlock {
  std::uint32_t solid;   ///< of HapticModel::solids()
  std::uint32_t block;   ///< of its lattice
  std::uint32_t period;  ///< WearPeriod::number
  std::int32_t entry;    ///< SparseField::kAbove: all of it is gone; else `points` tells
  std::array<float, SparseField::kPoints> points;
};

/// The block that has waited longest to be told, of the first solid that has any; its period is
/// left alone.  False where there is none.  Real-time.
bool TakeChanged(std::span<CutField> cuts, CutBlock& told) noexcept;

}  // namespace palpate
