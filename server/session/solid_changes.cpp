#include "server/session/solid_changes.h"

#include <algorithm>
#include <array>
#include <utility>

#include "common/files/bundle_hash.h"
#include "scenes/grid/surface_code.h"

namespace palpate {
namespace {

/// Size of a sample besides its surface [bytes].
constexpr double kHead = 110.0;

/// Returns the volume of each material that is gone from a block, without the zeros at the end
/// [mm^3]; over all blocks it is what CutField::VolumeLeft has lost, which scores are made of.
std::vector<float> RemovedFrom(const CutField& whole, const CutField& cut, std::size_t block) {
  std::vector<float> removed_mm3;
  const SparseField& field = cut.field();
  if (field.entry(block) == SparseField::kBelow) return removed_mm3;
  const Lattice& lattice = field.lattice();
  const double h = lattice.spacing, voxel_mm3 = 1e9 * h * h * h;
  std::array<double, SolidGrid::kMaterials> removed{};
  const std::array<int, 3> at = lattice.BlockAt(block);
  for (int n = 0; n < SparseField::kPoints; ++n) {
    const int i = 8 * at[0] + (n & 7), j = 8 * at[1] + (n >> 3 & 7), k = 8 * at[2] + (n >> 6);
    if (field.At(i, j, k) < -h) continue;  // no bur has reached that voxel
    removed[cut.solid().MaterialOf(block, n)] += whole.Left(i, j, k) - cut.Left(i, j, k);
  }
  for (const double voxels : removed) {
    removed_mm3.push_back(static_cast<float>(voxel_mm3 * voxels));
  }
  while (!removed_mm3.empty() && removed_mm3.back() == 0.0f) removed_mm3.pop_back();
  return removed_mm3;
}

std::uint64_t HashOf(const std::vector<float>& values) {
  return BundleHash({reinterpret_cast<const std::uint8_t*>(values.data()), 4 * values.size()});
}

/// Returns a block and those beside it.
std::vector<std::uint32_t> Round(const Lattice& lattice, std::uint32_t block) {
  std::vector<std::uint32_t> round;
  const std::array<int, 3> at = lattice.BlockAt(block);
  for (int n = 0; n < 27; ++n) {
    const int i = at[0] + n % 3 - 1, j = at[1] + n / 3 % 3 - 1, k = at[2] + n / 9 - 1;
    if (i < 0 || j < 0 || k < 0 || i >= lattice.blocks[0] || j >= lattice.blocks[1] ||
        k >= lattice.blocks[2]) {
      continue;
    }
    round.push_back(
        static_cast<std::uint32_t>((k * lattice.blocks[1] + j) * lattice.blocks[0] + i));
  }
  return round;
}

}  // namespace

SolidChanges::SolidChanges(std::span<const CutSolid> solids, const std::vector<CutField>& cuts) {
  for (std::size_t i = 0; i < solids.size(); ++i) {
    solids_.push_back({&solids[i], &cuts[i], CutField(*solids[i].grid, kMostGridBytes, "", 1)});
  }
}

void SolidChanges::Wait(const Place& place, std::int64_t now_ns) {
  const auto [it, is_new] =
      solids_[place.solid].waiting.try_emplace(place.block, Times{now_ns, now_ns});
  it->second.last_ns = now_ns;
  if (is_new) line_.push_back(place);
}

void SolidChanges::Take(std::uint32_t solid, std::uint32_t block, std::int64_t now_ns) {
  const Lattice& lattice = solids_[solid].cut->field().lattice();
  for (const std::uint32_t other : Round(lattice, block)) Wait({solid, other}, now_ns);
}

void SolidChanges::TellAgain(const wire::SolidBlock& block, std::int64_t now_ns) {
  const auto of = std::ranges::find_if(
      solids_, [&](const Solid& s) { return s.solid->object == block.object_index; });
  of->published.erase(block.block);
  Wait({static_cast<std::size_t>(of - solids_.begin()), block.block}, now_ns);
}

void SolidChanges::MakeWhole() {
  for (Solid& solid : solids_) {
    solid.published.clear();
    solid.waiting.clear();
  }
  line_.clear();
}

bool SolidChanges::Tell(const Place& place, SolidBlockNews& news) {
  Solid& at = solids_[place.solid];
  const SolidGrid& grid = *at.solid->grid;
  const SparseField& field = at.cut->field();
  const Lattice& lattice = field.lattice();
  const bool cut = field.entry(place.block) != SparseField::kBelow;
  // It closes the seam round a cut block; if there is none any more, viewers see the mesh again.
  const bool is_seen = cut || std::ranges::any_of(Round(lattice, place.block), [&](auto block) {
                         return field.entry(block) != SparseField::kBelow;
                       });
  surface_.Clear();
  if (is_seen) TakeSurface(grid, field, place.block, surface_);
  const std::array<int, 3> block = lattice.BlockAt(place.block);
  EncodeSurface(surface_, lattice.Point(8 * block[0], 8 * block[1], 8 * block[2]), lattice.spacing,
                news.surface);
  news.removed_mm3 = RemovedFrom(at.whole, *at.cut, place.block);
  // If it has no surface, and had none, and lacks nothing, nothing need be published.
  const bool bare = surface_.triangles.empty() && news.removed_mm3.empty() &&
                    (!cut || grid.field().entry(place.block) < 0);
  if (bare && !at.published.contains(place.block)) return false;
  const std::uint64_t hash = BundleHash(news.surface) + HashOf(news.removed_mm3) + (cut ? 1 : 0);
  const auto [published, is_first] = at.published.try_emplace(place.block, hash);
  if (!is_first && std::exchange(published->second, hash) == hash) return false;
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
  // Blocks that the bur has left come first; the others are hidden by it.
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
        const std::size_t more = one.surface.size() + 4 * one.removed_mm3.size();
        bytes_.Spend(kHead + static_cast<double>(more), now_ns);
        one.sample.change = ++count;
        news.push_back(std::move(one));
      }
      place = line_.erase(place);
    }
  }
}

}  // namespace palpate
