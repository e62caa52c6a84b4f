#include "server/session/cut_block.h"

#include <algorithm>

namespace palpate {

bool TakeChanged(std::span<CutField> cuts, CutBlock& told) noexcept {
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    std::size_t block = 0;
    if (!cuts[i].TakeChanged(block)) continue;
    const SparseField& field = cuts[i].field();
    told.solid = static_cast<std::uint32_t>(i);
    told.block = static_cast<std::uint32_t>(block);
    told.entry = field.entry(block);
    if (told.entry >= 0) {
      std::copy_n(field.values(told.entry), SparseField::kPoints, told.points.data());
    }
    return true;
  }
  return false;
}

}  // namespace palpate
