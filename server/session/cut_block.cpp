#include "server/session/cut_block.h"

#include <algorithm>

namespace palpate {

void CopyBlock(const SparseField& field, std::size_t block, CutBlock& copy) noexcept {
  copy.block = static_cast<std::uint32_t>(block);
  copy.entry = field.entry(block);
  if (copy.entry >= 0) {
    std::copy_n(field.values(copy.entry), SparseField::kPoints, copy.points.data());
  }
}

bool TakeChanged(std::span<CutField> cuts, CutBlock& published) noexcept {
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    std::size_t block = 0;
    if (!cuts[i].TakeChanged(block)) continue;
    published.solid = static_cast<std::uint32_t>(i);
    CopyBlock(cuts[i].field(), block, published);
    return true;
  }
  return false;
}

}  // namespace palpate
