#include "server/session/solid_changes.h"

#include <algorithm>
#include <array>
#include <utility>

#include "common/files/bundle_hash.h"
#include "scenes/grid/surface_code.h"

namespace palpate {
namespace {

/// What a sample takes besides its surface [bytes].
constexpr double kHead = 110.0;

}  // namespace

SolidChanges::Solid::Solid(const CutSolid& s)
    : solid(&s), field(s.grid->field().lattice(), s.grid->field().band(), SparseField::kBelow) {
  field.Reserve(s.grid->solid_blocks());
}

SolidChanges::SolidChanges(std::span<const CutSolid> solids)
    : solids_(solids.begin(), solids.end()) {}

void SolidChanges::Take(const CutBlock& block, std::int64_t now_ns) {
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
  WaitRound(block.solid, block.block, now_ns);
}

void SolidChanges::Wait(const Place& place, std::int64_t now_ns) {
  const auto [it, is_new] =
      solids_[place.solid].waiting.try_emplace(place.block, Times{now_ns, now_ns});
  it->second.last_ns = now_ns;
  if (is_new) line_.push_back(place);
}

void SolidChanges::WaitRound(std::size_t solid, std::uint32_t block, std::int64_t now_ns) {
  const SparseField& field = solids_[solid].field;
  const Lattice& lattice = field.lattice();
  const std::array<int, 3> place = lattice.BlockAt(block);
  for (int n = 0; n < 27; ++n) {
    const int i = place[0] + n % 3 - 1, j = place[1] + n / 3 % 3 - 1, k = place[2] + n / 9 - 1;
    if (i < 0 || j < 0 || k < 0 || i >= lattice.blocks[0] || j >= lattice.blocks[1] ||
        k >= lattice.blocks[2]) {
      continue;
    }
    Wait({solid, static_cast<std::uint32_t>(field.BlockIndex(i, j, k))}, now_ns);
  }
}

void SolidChanges::TellAgain(const wire::SolidBlock& block, std::int64_t now_ns) {
  const auto of = std::ranges::find_if(
      solids_, [&](const Solid& s) { return s.solid->object == block.object_index; });
  of->told.erase(block.block);
  Wait({static_cast<std::size_t>(of - solids_.begin()), block.block}, now_ns);
}

void SolidChanges::Keep(std::vector<CutField> cuts, std::int64_t now_ns) {
  for (CutBlock block; TakeChanged(cuts, block);) Take(block, now_ns);
  if (!whole_) kept_ = std::move(cuts);
}

void SolidChanges::MakeWhole() {
  for (Solid& solid : solids_) {
    solid.field.Clear();
    solid.told.clear();
    solid.waiting.clear();
  }
  line_.clear();
  kept_.clear();
  whole_ = true;
}

bool SolidChanges::Tell(const Place& place, SolidBlockNews& news) {
  Solid& at = solids_[place.solid];
  const SolidGrid& grid = *at.solid->grid;
  const Lattice& lattice = at.field.lattice();
  TakeSurface(grid, at.field, place.block, surface_);
  const std::array<int, 3> block = lattice.BlockAt(place.block);
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
  int made = 0;
  // What the bur has left is to be seen first: the rest is below it.
  for (const bool left : {true, false}) {
    for (auto place = line_.begin(); place != line_.end();) {
      const auto waits = solids_[place->solid].waiting.find(place->block);
      const auto& [first_ns, last_ns] = waits->second;
      if (left ? now_ns - last_ns < kLeft_ns : now_ns - first_ns < kUnderBur_ns) {
        ++place;
        continue;
      }
      if (++made > kMostAtOnce || bytes_.WaitFor(kHead, now_ns) > 0) return;
      solids_[place->solid].waiting.erase(waits);
      SolidBlockNews one;
      if (Tell(*place, one)) {
        bytes_.Spend(kHead + static_cast<double>(one.surface.size()), now_ns);
        one.sample.change = ++count;
        news.push_back(std::move(one));
      }
      place = line_.erase(place);
    }
  }
}

}  // namespace palpate
