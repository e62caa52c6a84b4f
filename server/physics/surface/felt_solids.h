#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "scenes/grid/cut_field.h"
#include "server/physics/surface/block_bodies.h"
#include "server/physics/surface/separation_front.h"

namespace palpate {

/// What is left of a scene's solids as contact feels it: bodies of their blocks.
///
/// Of a block that is cut, or beside one, a body is made when a pair of the front first has to look
/// into its box: of a copy of what was cut, which follows it in turns, so that all bodies are of
/// one time and join (README.md).  All other blocks have the bodies that were made with the scene.
///
/// A value: copied, it goes on alike.  Real-time but for the constructor, as long as no block has
/// more than limits::mesh::kMostOfBlock triangles: a block that has is closed to tools.
class FeltSolids {
 public:
  FeltSolids() = default;
  /// What it is given outlives it.  Blocks have the numbers after the boxes'.
  explicit FeltSolids(const UncutBodies& uncut);

  bool empty() const { return solids_.empty(); }
  /// To be called before the first step, where what was cut is another's, or grows again: the next
  /// Begin takes it all at once.
  void Forget() { forgotten_ = true; }
  /// Where a cycle begins, and before anything else is asked.
  void Begin(std::span<const CutField> cuts, SeparationFront& front) noexcept;
  /// Follows what was cut, where a cycle ends.
  void Follow(std::span<const CutField> cuts, SeparationFront& front) noexcept;

  /// The body of a block by its number, which is not that of any of the scene's own.
  const ContactBody& Body(std::int32_t number) const { return BodyOf(number).body; }
  /// Whether a number stands for blocks with nothing in them, and not for a body.
  bool IsNothing(std::int32_t number) const {
    return number < first_uncut_ && PlaceOf(number) >= bodies_.size();
  }
  using Block = BlockBody::Of;
  struct Taken {
    std::int32_t body;  ///< -1: there is no room
    bool made;          ///< which costs about limits::mesh::kLooksOfBlock
  };
  /// The body of a block, in place of one that no pair of the front has where there is no room.
  Taken Take(const Block& block, const SeparationFront& front) noexcept;
  /// Material of a triangle's solid, and which solid that is.
  std::uint8_t MaterialOf(std::int32_t number, std::int32_t triangle) const {
    return BodyOf(number).materials[static_cast<std::size_t>(triangle)];
  }
  std::size_t SolidOf(std::int32_t number) const {
    return static_cast<std::size_t>(BodyOf(number).of.solid - first_solid_);
  }

 private:
  static constexpr std::int16_t kNone = -1, kNothing = -2, kUncut = -3, kNoRoom = -4;
  enum class Use : std::uint8_t { kFree, kFelt, kLater };
  struct Place {
    BlockBody body;
    Use use = Use::kFree;
  };
  struct Solid {
    explicit Solid(const CutSolid& cut_solid);

    const CutSolid* solid;
    SparseField felt;           ///< the copy
    SparseField later;          ///< of blocks that are being followed, what comes next
    std::uint32_t changes = 0;  ///< CutField::changes that are followed
    // Of each block.
    std::vector<std::uint32_t> followed;         ///< CutField::ChangedAt of what is or will be felt
    std::vector<std::uint32_t> affected;         ///< the last turn in which its surface changes
    std::vector<std::uint32_t> affected_blocks;  ///< for which that is this turn
    std::vector<std::uint32_t> listed;           ///< the last turn for which it is to be made
    std::vector<std::int16_t> place, later_place;  ///< kNone, kNothing, kUncut
  };

  std::size_t PlaceOf(std::int32_t number) const {
    return static_cast<std::size_t>(number - first_block_);
  }
  Solid& SolidOf(const Block& block) {
    return solids_[static_cast<std::size_t>(block.solid - first_solid_)];
  }
  const BlockBody& BodyOf(std::int32_t number) const {
    return number < first_uncut_ ? bodies_[PlaceOf(number)].body
                                 : (*uncut_)[static_cast<std::size_t>(number - first_uncut_)];
  }
  void TakeAll(std::span<const CutField> cuts) noexcept;
  void Gather(std::span<const CutField> cuts, const SeparationFront& front) noexcept;
  bool IsFollowed(std::span<const CutField> cuts) const noexcept;
  bool IsKnownRound(const Solid& solid, std::size_t block) const noexcept;
  static bool IsUncut(const SparseField& felt, std::size_t block) noexcept;
  void MarkAffected(Solid& solid, std::size_t block) noexcept;
  void List(const Block& block) noexcept;
  void Commit(SeparationFront& front) noexcept;
  Block BlockOf(const SeparationFront::Pair& entry) const;
  void FollowOne(const Block& block, const SeparationFront& front) noexcept;
  /// Into the scratch; how many triangles are its own.
  std::size_t TakeSurfaceOf(const Block& block, Use use) noexcept;
  std::int16_t MakeOfSurface(const Block& block, std::size_t own, Use use,
                             const SeparationFront& front) noexcept;
  /// Its place; kNothing, kNoRoom.
  std::int16_t Make(const Block& block, Use use, const SeparationFront& front) noexcept;
  bool MakeRoom(const SeparationFront& front) noexcept;
  void Free(std::size_t place) noexcept;

  std::int32_t first_solid_ = 0, first_block_ = 0, first_uncut_ = 0;
  const UncutBodies* uncut_ = nullptr;
  std::vector<Solid> solids_;
  std::vector<Place> bodies_;
  std::vector<std::int16_t> free_;  ///< a stack
  std::size_t next_given_up_ = 0;
  bool forgotten_ = true;

  struct Changed {
    std::int32_t solid;
    std::uint32_t block;
  };
  /// Blocks that have changed and are not felt so yet, and the bodies that are made for them.
  struct Followed {
    std::uint32_t turn = 0;
    std::vector<Changed> changed;
    std::vector<Block> to_make;
    std::size_t made = 0;
    std::optional<std::size_t> own_of_next;  ///< triangles, where the scratch has its surface

    bool any() const { return !changed.empty(); }
    void Clear() {
      changed.clear();
      to_make.clear();
      made = 0;
      own_of_next.reset();
    }
  } followed_;
  int made_in_cycle_ = 0;

  // Scratch.
  BlockBody::Scratch scratch_;
  std::vector<bool> used_;
};

}  // namespace palpate
