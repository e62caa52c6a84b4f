#include "server/physics/surface/solid_bodies.h"

#include <algorithm>

#include "server/physics/limits.h"

namespace palpate {
namespace {

using namespace limits::mesh;
constexpr int kSide = SparseField::kSide;
constexpr std::size_t kPoints = SparseField::kPoints;
/// A change in the first kOfBefore layers of a block also affects triangles of the block before it;
/// one in the last kOfBeyond layers, those of the block beyond it.
constexpr int kOfBefore = 4, kOfBeyond = 5;

/// Gives all points of a block the same value.
void Fill(SparseField& field, std::size_t block, std::int32_t entry) noexcept {
  if (field.entry(block) >= 0) {
    field.Release(block, entry);
  } else {
    field.Fill(block, entry);
  }
}

void Copy(const SparseField& from, std::size_t block, SparseField& to) noexcept {
  const std::int32_t source = from.entry(block);
  if (source < 0) return Fill(to, block, source);
  std::int32_t target = to.entry(block);
  if (target < 0) target = to.Acquire(block);
  std::copy_n(from.values(source), kPoints, to.values(target));
}

/// Returns whether something holds for a block and all blocks round it: holds(block, by), with `by`
/// the way there in blocks.
template <typename Holds>
bool AllRound(const SparseField& field, std::size_t block, const Holds& holds) {
  const auto& blocks = field.lattice().blocks;
  const auto at = field.lattice().BlockAt(block);
  for (int n = 0; n < 27; ++n) {
    const std::array<int, 3> by{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
    const int x = at[0] + by[0], y = at[1] + by[1], z = at[2] + by[2];
    if (std::min({x, y, z}) < 0 || x >= blocks[0] || y >= blocks[1] || z >= blocks[2]) continue;
    if (!holds(field.BlockIndex(x, y, z), by)) return false;
  }
  return true;
}

}  // namespace

SolidBodies::Solid::Solid(const CutSolid& cut_solid)
    : solid(&cut_solid),
      shown(cut_solid.grid->field().lattice(), cut_solid.grid->field().band(), SparseField::kBelow),
      later(shown),
      followed(shown.lattice().block_count()),
      affected(followed.size()),
      listed(followed.size()),
      place(followed.size(), kNone),
      later_place(place) {
  shown.Reserve(cut_solid.grid->solid_blocks());
  later.Reserve(kMostFollowed);
  affected_blocks.reserve(27 * kMostFollowed);
}

SolidBodies::SolidBodies(const UncutBodies& uncut)
    : first_solid_(uncut.first_body),
      first_block_(first_solid_ + static_cast<std::int32_t>(uncut.solids.size())),
      first_uncut_(first_block_ + static_cast<std::int32_t>(kBlocks + uncut.solids.size())),
      uncut_(&uncut) {
  if (uncut.solids.empty()) return;
  solids_.reserve(uncut.solids.size());
  for (const CutSolid& solid : uncut.solids) solids_.emplace_back(solid);
  bodies_.resize(kBlocks);
  used_.resize(kBlocks);
  free_.reserve(kBlocks);
  for (std::size_t place = kBlocks; place-- > 0;) {
    free_.push_back(static_cast<std::int16_t>(place));
    bodies_[place].body.Reserve();
  }
  scratch_.Reserve();
  followed_.changed.reserve(kMostFollowed);
  followed_.to_make.reserve(kBlocks);
}

void SolidBodies::Begin(std::span<const CutField> cuts, SeparationFront& front) noexcept {
  made_in_cycle_ = 0;
  bool is_followed = !forgotten_;  // else, or if there are more changes than can be, takes all
  for (std::size_t s = 0; s < solids_.size(); ++s) {
    is_followed = is_followed && cuts[s].changes() - solids_[s].changes <= CutField::kChanges;
  }
  if (is_followed) return;
  TakeAll(cuts);
  front.Clear();
  forgotten_ = false;
}

void SolidBodies::Follow(std::span<const CutField> cuts, SeparationFront& front) noexcept {
  if (!followed_.any()) Gather(cuts, front);
  if (!followed_.any()) return;
  if (made_in_cycle_ == 0 && followed_.made < followed_.to_make.size()) {
    FollowOne(followed_.to_make[followed_.made], front);
  }
  if (followed_.made == followed_.to_make.size()) Commit(front);
}

/// Computes its surface in one cycle, and a body from it in the next.
void SolidBodies::FollowOne(const Block& block, const SeparationFront& front) noexcept {
  std::optional<std::size_t>& own = followed_.own_of_next;
  if (!own) {
    own = TakeSurfaceOf(block, Use::kLater);
    if (*own > 0) return;
  }
  SolidOf(block).later_place[static_cast<std::size_t>(block.block)] =
      MakeOfSurface(block, *own, Use::kLater, front);
  own.reset();
  ++followed_.made;
}

void SolidBodies::TakeAll(std::span<const CutField> cuts) noexcept {
  for (std::size_t place = 0; place < bodies_.size(); ++place) Free(place);
  for (const Block& changed : followed_.changed) {  // not copied yet
    SolidOf(changed).followed[static_cast<std::size_t>(changed.block)] = ~0u;
  }
  for (std::size_t s = 0; s < solids_.size(); ++s) {
    Solid& solid = solids_[s];
    const CutField& cut = cuts[s];
    solid.later.Clear();
    solid.affected_blocks.clear();
    std::fill(solid.place.begin(), solid.place.end(), kNone);
    for (std::size_t block = 0; block < solid.followed.size(); ++block) {
      if (cut.ChangedAt(block) == solid.followed[block]) continue;
      solid.followed[block] = cut.ChangedAt(block);
      Copy(cut.field(), block, solid.shown);
    }
    solid.changes = cut.changes();
  }
  followed_.Clear();
}

/// Copies blocks that have changed, and finds the bodies that must be remade for them.
void SolidBodies::Gather(std::span<const CutField> cuts, const SeparationFront& front) noexcept {
  for (std::size_t s = 0; s < solids_.size(); ++s) {
    Solid& solid = solids_[s];
    const CutField& cut = cuts[s];
    for (; solid.changes != cut.changes() && followed_.changed.size() < kMostFollowed;
         ++solid.changes) {
      const std::size_t block = cut.Changed(solid.changes + 1);
      if (cut.ChangedAt(block) == solid.followed[block]) continue;
      solid.followed[block] = cut.ChangedAt(block);
      // Nothing is known of it, nor of the blocks whose triangles depend on its points.
      if (AllRound(solid.shown, block,
                   [&](std::size_t n, auto) { return solid.place[n] == kNone; })) {
        Copy(cut.field(), block, solid.shown);
        continue;
      }
      if (!followed_.any()) ++followed_.round;
      Copy(cut.field(), block, solid.later);
      MarkAffected(solid, block);
      followed_.changed.push_back(
          {first_solid_ + static_cast<std::int32_t>(s), 0, static_cast<std::int32_t>(block)});
    }
  }
  if (!followed_.any()) return;
  front.ForEachEntry(first_block_, [&](SeparationFront::Index, const SeparationFront::Pair& pair) {
    List(BlockOf(pair));
  });
}

/// Marks the blocks whose triangles depend on points that have changed.
void SolidBodies::MarkAffected(Solid& solid, std::size_t block) noexcept {
  const std::int32_t was = solid.shown.entry(block), is = solid.later.entry(block);
  const float all = was == SparseField::kAbove ? solid.shown.band() : -solid.shown.band();
  // For each axis, bits of the layers that have a change.
  unsigned layers[3] = {};
  for (int n = 0; n < SparseField::kPoints; n += kSide) {
    unsigned along = 0;
    for (int x = 0; x < kSide; ++x) {
      const float before = was >= 0 ? solid.shown.values(was)[n + x] : all;
      const float after = is >= 0 ? solid.later.values(is)[n + x] : solid.shown.band();
      along |= static_cast<unsigned>(before != after) << x;
    }
    if (along == 0) continue;
    layers[0] |= along;
    layers[1] |= 1u << (n >> 3 & 7);
    layers[2] |= 1u << (n >> 6);
  }
  constexpr unsigned kLow = (1u << kOfBefore) - 1,
                     kHigh = 0xffu & ~((1u << (kSide - kOfBeyond)) - 1);
  AllRound(solid.shown, block, [&](std::size_t reached, const std::array<int, 3>& by) {
    bool reaches = solid.affected[reached] != followed_.round;
    for (std::size_t a = 0; a < 3; ++a) {
      reaches = reaches && (layers[a] & (by[a] < 0 ? kLow : by[a] > 0 ? kHigh : 0xffu)) != 0;
    }
    if (!reaches) return true;
    solid.affected[reached] = followed_.round;
    solid.affected_blocks.push_back(static_cast<std::uint32_t>(reached));
    return true;
  });
}

/// Lists a block to be remade in this round, if it changes.
void SolidBodies::List(const Block& block) noexcept {
  Solid& solid = SolidOf(block);
  const auto b = static_cast<std::size_t>(block.block);
  if (solid.affected[b] != followed_.round || solid.listed[b] == followed_.round) return;
  if (followed_.to_make.size() == kBlocks) return;
  solid.listed[b] = followed_.round;
  followed_.to_make.push_back(block);
}

void SolidBodies::Commit(SeparationFront& front) noexcept {
  for (const Block& changed : followed_.changed) {
    Solid& solid = SolidOf(changed);
    Copy(solid.later, static_cast<std::size_t>(changed.block), solid.shown);
    Fill(solid.later, static_cast<std::size_t>(changed.block), SparseField::kBelow);
  }
  front.CloseEntries(
      first_block_, [&](const SeparationFront::Pair& pair, SeparationFront::Pair& outside) {
        const Block of = BlockOf(pair);
        if (SolidOf(of).affected[static_cast<std::size_t>(of.block)] != followed_.round)
          return false;
        outside.body = of.solid;
        outside.b = of.node;
        return true;
      });
  for (Solid& solid : solids_) {
    for (const std::uint32_t block : solid.affected_blocks) {
      if (solid.place[block] >= 0) Free(static_cast<std::size_t>(solid.place[block]));
      solid.place[block] = kNone;
    }
    solid.affected_blocks.clear();
  }
  for (const Block& block : followed_.to_make) {
    Solid& solid = SolidOf(block);
    std::int16_t& later = solid.later_place[static_cast<std::size_t>(block.block)];
    if (later >= 0) bodies_[static_cast<std::size_t>(later)].use = Use::kShown;
    if (later != kNoRoom) solid.place[static_cast<std::size_t>(block.block)] = later;
    later = kNone;
  }
  followed_.Clear();
}

SolidBodies::Block SolidBodies::BlockOf(const SeparationFront::Pair& entry) const {
  if (!IsNothing(entry.body)) return Body(entry.body).of;
  const std::size_t solid = PlaceOf(entry.body) - bodies_.size();
  return {first_solid_ + static_cast<std::int32_t>(solid), entry.b,
          uncut_->boxes[solid].shape->tree.BlockOf(entry.b)};
}

SolidBodies::Taken SolidBodies::Take(const Block& block, const SeparationFront& front) noexcept {
  Solid& solid = SolidOf(block);
  std::int16_t& place = solid.place[static_cast<std::size_t>(block.block)];
  const std::int32_t nothing =
      first_block_ + static_cast<std::int32_t>(bodies_.size()) + block.solid - first_solid_;
  if (place >= 0) return {first_block_ + place, false};
  const auto s = static_cast<std::size_t>(block.solid - first_solid_);
  const std::int32_t whole = uncut_->place[s][static_cast<std::size_t>(block.block)];
  const auto is_whole = [&](std::size_t n, auto) {
    return solid.shown.entry(n) == SparseField::kBelow;
  };
  if (place == kNone && AllRound(solid.shown, static_cast<std::size_t>(block.block), is_whole)) {
    place = whole < 0 ? kNothing : kUncut;
    if (followed_.any()) List(block);
  }
  if (place == kUncut) return {first_uncut_ + whole, false};
  if (place == kNothing) return {nothing, false};
  ++made_in_cycle_;
  followed_.own_of_next.reset();  // it was in the scratch
  const std::int16_t made =
      MakeOfSurface(block, TakeSurfaceOf(block, Use::kShown), Use::kShown, front);
  if (followed_.any()) List(block);
  if (made == kNoRoom) return {-1, true};
  place = made;
  return made == kNothing ? Taken{nothing, false} : Taken{first_block_ + made, true};
}

std::size_t SolidBodies::TakeSurfaceOf(const Block& block, Use use) noexcept {
  const Solid& solid = SolidOf(block);
  return TakeSurfaceAndRim(
      {*solid.solid->grid, solid.shown, use == Use::kLater ? &solid.later : nullptr},
      static_cast<std::size_t>(block.block), scratch_.surface);
}

std::int16_t SolidBodies::MakeOfSurface(const Block& block, std::size_t own, Use use,
                                        const SeparationFront& front) noexcept {
  if (own == 0) return kNothing;
  if (scratch_.surface.triangles.size() > kMostOfBlock) return kNoRoom;
  if (free_.empty() && !MakeRoom(front)) return kNoRoom;
  const std::int16_t at = free_.back();
  free_.pop_back();
  Place& place = bodies_[static_cast<std::size_t>(at)];
  place.use = use;
  place.body.Assign(block, own, scratch_);
  return at;
}

/// Discards some bodies that no pair of the front uses, cycling through all.
bool SolidBodies::MakeRoom(const SeparationFront& front) noexcept {
  std::fill(used_.begin(), used_.end(), false);
  front.ForEachEntry(first_block_, [&](SeparationFront::Index, const SeparationFront::Pair& pair) {
    if (PlaceOf(pair.body) < kBlocks) used_[PlaceOf(pair.body)] = true;
  });
  for (std::size_t n = 0; n < kBlocks && free_.size() < kGivenUp; ++n) {
    const std::size_t place = next_given_up_;
    if (++next_given_up_ == bodies_.size()) next_given_up_ = 0;
    if (bodies_[place].use == Use::kShown && !used_[place]) Free(place);
  }
  return !free_.empty();
}

void SolidBodies::Free(std::size_t place) noexcept {
  Use& use = bodies_[place].use;
  if (use == Use::kFree) return;
  const Block& of = bodies_[place].body.of;
  Solid& solid = SolidOf(of);
  (use == Use::kShown ? solid.place : solid.later_place)[static_cast<std::size_t>(of.block)] =
      kNone;
  use = Use::kFree;
  free_.push_back(static_cast<std::int16_t>(place));
}

}  // namespace palpate
