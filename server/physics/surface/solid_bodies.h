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

/// What is left of a scene's solids, as contact sees it: one body for each block, and rounds in
/// which bodies follow what is cut (README.md, "Solids that are cut").
/// A value: a copy behaves alike.  Real-time except for the constructor, as long as no block has
/// more than limits::mesh::kMostOfBlock triangles; a block with more is closed to tools.
class SolidBodies {
 public:
  SolidBodies() = default;
  /// `uncut` must outlive this object.  Bodies of blocks are numbered after those of the boxes.
  explicit SolidBodies(const UncutBodies& uncut);

  bool empty() const { return solids_.empty(); }
  /// Call before the first step, when the cut fields are replaced, or when material grows back: the
  /// next Begin then takes over all of them at once.
  void Forget() { forgotten_ = true; }
  /// Starts a cycle.  Call before any query.
  void Begin(std::span<const CutField> cuts, SeparationFront& front) noexcept;
  /// Ends a cycle: follows what was cut.
  void Follow(std::span<const CutField> cuts, SeparationFront& front) noexcept;

  /// Returns the body of a block by its number, which differs from those of the scene's own bodies.
  const BlockBody& Body(std::int32_t number) const {
    return number < first_uncut_ ? bodies_[PlaceOf(number)].body
                                 : uncut_->bodies[static_cast<std::size_t>(number - first_uncut_)];
  }
  /// Returns whether a number stands for an empty block, which has no body.
  bool IsNothing(std::int32_t number) const {
    return number < first_uncut_ && PlaceOf(number) >= bodies_.size();
  }
  using Block = BlockBody::Of;
  struct Taken {
    std::int32_t body;  ///< -1: there is no room, or too many triangles
    bool made;          ///< whether this cost some limits::mesh::kQueriesOfBlock
  };
  /// Returns the body of a block, making it if needed.  If there is no room, it replaces a body
  /// that no pair of the front uses.
  Taken Take(const Block& block, const SeparationFront& front) noexcept;
  /// The material of a triangle, and the index of the solid that it belongs to.
  std::uint8_t MaterialOf(std::int32_t number, std::int32_t triangle) const {
    return Body(number).materials[static_cast<std::size_t>(triangle)];
  }
  std::size_t SolidOf(std::int32_t number) const {
    return static_cast<std::size_t>(Body(number).of.solid - first_solid_);
  }

 private:
  static constexpr std::int16_t kNone = -1, kNothing = -2, kUncut = -3, kNoRoom = -4;
  enum class Use : std::uint8_t { kFree, kShown, kLater };
  struct Place {
    BlockBody body;
    Use use = Use::kFree;
  };
  struct Solid {
    explicit Solid(const CutSolid& cut_solid);

    const CutSolid* solid;
    SparseField shown;          ///< the copy that bodies show
    SparseField later;          ///< blocks being followed: the content that comes next
    std::uint32_t changes = 0;  ///< CutField::changes up to which this follows
    // For each block:
    std::vector<std::uint32_t> followed;  ///< CutField::ChangedAt of what is shown, or soon will be
    std::vector<std::uint32_t> affected;  ///< the last round in which its surface changes
    std::vector<std::uint32_t> affected_blocks;  ///< (not by block) those affected in this round
    std::vector<std::uint32_t> listed;  ///< the last round for which its body is to be made
    std::vector<std::int16_t> place, later_place;  ///< kNone, kNothing, kUncut
  };

  std::size_t PlaceOf(std::int32_t number) const {
    return static_cast<std::size_t>(number - first_block_);
  }
  Solid& SolidOf(const Block& block) {
    return solids_[static_cast<std::size_t>(block.solid - first_solid_)];
  }
  void TakeAll(std::span<const CutField> cuts) noexcept;
  void Gather(std::span<const CutField> cuts, const SeparationFront& front) noexcept;
  void MarkAffected(Solid& solid, std::size_t block) noexcept;
  void List(const Block& block) noexcept;
  void Commit(SeparationFront& front) noexcept;
  Block BlockOf(const SeparationFront::Pair& entry) const;
  void FollowOne(const Block& block, const SeparationFront& front) noexcept;
  /// Fills the scratch with a block's surface; returns how many triangles are its own.
  std::size_t TakeSurfaceOf(const Block& block, Use use) noexcept;
  /// Makes a block's body of it; returns its place, kNothing or kNoRoom.
  std::int16_t MakeOfSurface(const Block& block, std::size_t own, Use use,
                             const SeparationFront& front) noexcept;
  bool MakeRoom(const SeparationFront& front) noexcept;
  void Free(std::size_t place) noexcept;

  std::int32_t first_solid_ = 0, first_block_ = 0, first_uncut_ = 0;
  const UncutBodies* uncut_ = nullptr;
  std::vector<Solid> solids_;
  std::vector<Place> bodies_;
  std::vector<std::int16_t> free_;  ///< a stack of unused places
  std::size_t next_given_up_ = 0;
  bool forgotten_ = true;

  /// Blocks that have changed but are not shown so yet, and the new bodies made for them.
  struct Followed {
    std::uint32_t round = 0;
    std::vector<Block> changed;  ///< without their nodes
    std::vector<Block> to_make;
    std::size_t made = 0;
    /// Number of the next block's own triangles, once the scratch holds its surface.
    std::optional<std::size_t> own_of_next;

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
