#include "server/session/solid_changes.h"

#include <algorithm>
#include <array>
#include <utility>

#include "common/files/bundle_hash.h"
#include "scenes/grid/surface_code.h"

namespace palpate {
namespace {

/// What a sample takes besides its surface [bytes].
constexpr double kHead = 150.0;

std::array<int, 3> PlaceOf(const Lattice& lattice, std::uint32_t block) {
  const auto n = static_cast<int>(block);
  const auto& blocks = lattice.blocks;
  return {n % blocks[0], n / blocks[0] % blocks[1], n / blocks[0] / blocks[1]};
}

}  // namespace

SolidChanges::Solid::Solid(const CutSolid& s)
    : solid(&s),
      field(s.grid->field().lattice(), s.grid->field().band(), SparseField::kBelow),
      waits(field.lattice().block_count()) {
  field.Reserve(s.grid->solid_blocks());
}

SolidChanges::SolidChanges(std::span<const CutSolid> solids)
    : solids_(solids.begin(), solids.end()) {}

void SolidChanges::Take(const CutBlock& block) {
  whole_ = false;
  SparseField& field = solids_[block.solid].field;
  const std::int32_t before = field.entry(block.block);
  if (block.entry >= 0) {
    const std::int32_t entry = before >= 0 ? before : field.Acquire(block.block);
    std::ranges::copy(block.points, field.values(entry));
  } else if (before >= 0) {
    field.Release(block.block, block.entry);
  } else {
    field.Fill(block.block, block.entry);
  }
  WaitRound(block.solid, block.block);
}

void SolidChanges::WaitRound(std::size_t solid, std::uint32_t block) {
  Solid& at = solids_[solid];
  const Lattice& lattice = at.field.lattice();
  const std::array<int, 3> place = PlaceOf(lattice, block);
  for (int n = 0; n < 27; ++n) {
    const int i = place[0] + n % 3 - 1, j = place[1] + n / 3 % 3 - 1, k = place[2] + n / 9 - 1;
    if (i < 0 || j < 0 || k < 0 || i >= lattice.blocks[0] || j >= lattice.blocks[1] ||
        k >= lattice.blocks[2]) {
      continue;
    }
    const std::size_t beside = at.field.BlockIndex(i, j, k);
    if (at.waits[beside]) continue;
    at.waits[beside] = true;
    waiting_.push_back({solid, static_cast<std::uint32_t>(beside)});
  }
}

void SolidChanges::Keep(std::vector<CutField> cuts) {
  for (CutBlock block; TakeChanged(cuts, block);) Take(block);
  if (!whole_) kept_ = std::move(cuts);
}

void SolidChanges::MakeWhole() {
  for (Solid& solid : solids_) {
    solid.field.Clear();
    solid.told.clear();
    solid.waits.assign(solid.waits.size(), false);
  }
  waiting_.clear();
  kept_.clear();
  whole_ = true;
}

bool SolidChanges::Tell(const Place& place, SolidBlockNews& news) {
  Solid& at = solids_[place.solid];
  const SolidGrid& grid = *at.solid->grid;
  const Lattice& lattice = at.field.lattice();
  TakeSurface(grid, at.field, place.block, surface_);
  const std::array<int, 3> block = PlaceOf(lattice, place.block);
  EncodeSurface(surface_, lattice.Point(8 * block[0], 8 * block[1], 8 * block[2]), lattice.spacing,
                news.surface);
  const bool cut = at.field.entry(place.block) != SparseField::kBelow;
  // Where there is no surface, and was none, nobody need be told.
  const bool bare = surface_.triangles.empty() && (!cut || grid.field().entry(place.block) < 0);
  if (bare && !at.told.contains(place.block)) return false;
  const std::uint64_t hash = BundleHash(news.surface) + (cut ? 1 : 0);
  const auto [told, is_first] = at.told.try_emplace(place.block, hash);
  if (!is_first && std::exchange(told->second, hash) == hash) return false;
  wire::SolidBlock& sample = news.sample;
  sample.object_index = at.solid->object;
  sample.block = place.block;
  wire::FromVec3(lattice.origin, sample.origin_m);
  sample.spacing_m = lattice.spacing;
  for (std::size_t k = 0; k < 3; ++k) {
    sample.blocks[k] = static_cast<std::uint32_t>(lattice.blocks[k]);
  }
  sample.cut = cut;
  return true;
}

void SolidChanges::AddNews(std::int64_t now_ns, std::uint64_t& count,
                           std::vector<SolidBlockNews>& news) {
  for (int n = 0; n < kMostAtOnce && !waiting_.empty(); ++n) {
    if (bytes_.WaitFor(kHead, now_ns) > 0) return;
    const Place place = waiting_.front();
    waiting_.pop_front();
    solids_[place.solid].waits[place.block] = false;
    SolidBlockNews one;
    if (!Tell(place, one)) continue;
    bytes_.Spend(kHead + static_cast<double>(one.surface.size()), now_ns);
    one.sample.change = ++count;
    news.push_back(std::move(one));
  }
}

}  // namespace palpate
