#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/math/pose.h"

namespace palpate {

/// The points origin + spacing * (i, j, k), 8 times `blocks` of them along each axis.
struct Lattice {
  Vec3 origin = Vec3::Zero();  ///< body frame B [m]
  double spacing = 0.0;        ///< h [m]
  std::array<int, 3> blocks{};

  std::size_t block_count() const {
    return static_cast<std::size_t>(blocks[0]) * static_cast<std::size_t>(blocks[1]) *
           static_cast<std::size_t>(blocks[2]);
  }
  /// Returns a block's coordinates along each axis; the inverse of SparseField::BlockIndex.
  std::array<int, 3> BlockAt(std::size_t block) const {
    const auto wide = static_cast<std::size_t>(blocks[0]),
               deep = static_cast<std::size_t>(blocks[1]);
    return {static_cast<int>(block % wide), static_cast<int>(block / wide % deep),
            static_cast<int>(block / wide / deep)};
  }
  Vec3 Point(int i, int j, int k) const { return origin + spacing * Vec3(i, j, k); }
  /// Returns the corner opposite to the origin.
  Vec3 End() const { return Point(8 * blocks[0], 8 * blocks[1], 8 * blocks[2]); }

  /// The cell that contains a point of B, and the point's place in it.
  struct Place {
    bool inside;        ///< false, also for a point that is not finite: the rest is not set
    int c[3];           ///< lowest corner of the cell
    double u[3];        ///< place in the cell, 0 to 1 on each axis
    std::size_t block;  ///< block of that corner
  };
  Place PlaceOf(const Vec3& p_B) const noexcept;
};

/// A vector whose copies have the same capacity, so that what need not allocate in the original
/// does not in a copy either.
template <class T>
struct RoomyVector : std::vector<T> {
  RoomyVector() = default;
  RoomyVector(const RoomyVector& from) : std::vector<T>() { *this = from; }
  RoomyVector(RoomyVector&&) noexcept = default;
  RoomyVector& operator=(RoomyVector&&) noexcept = default;
  RoomyVector& operator=(const RoomyVector& from) {
    if (this == &from) return *this;
    this->reserve(from.capacity());
    this->assign(from.begin(), from.end());
    return *this;
  }
};

/// A signed distance and its gradient at a point.
/// @field distance  positive in free space, negative in the solid [m]; limited to the band.
/// @field gradient  of the interpolation: about a unit vector near a surface, zero beyond the band.
struct FieldSample {
  double distance = 0.0;
  Vec3 gradient = Vec3::Zero();
};

/// Numbers on a lattice, stored in blocks of 8^3 if they lie between -band and +band.  A block that
/// is all -band or all +band is only an entry of the table.
///
/// Reading is real-time.  So are Acquire and Release, within the reserved storage.
class SparseField {
 public:
  static constexpr int kSide = 8;
  static constexpr int kPoints = kSide * kSide * kSide;
  /// Table entries of blocks without storage: all -band, all +band.
  static constexpr std::int32_t kBelow = -1, kAbove = -2;

  /// `band`: > 0 [m]; `all`: kBelow or kAbove, the initial entry of every block, and the value
  /// outside the lattice.
  SparseField(const Lattice& lattice, float band, std::int32_t all);

  const Lattice& lattice() const { return lattice_; }
  float band() const { return band_; }

  std::size_t BlockIndex(int bi, int bj, int bk) const {
    return (static_cast<std::size_t>(bk) * static_cast<std::size_t>(lattice_.blocks[1]) +
            static_cast<std::size_t>(bj)) *
               static_cast<std::size_t>(lattice_.blocks[0]) +
           static_cast<std::size_t>(bi);
  }
  static int PointIndex(int i, int j, int k) { return ((k & 7) << 6) | ((j & 7) << 3) | (i & 7); }
  /// the entry that stands for all outside the lattice
  std::int32_t around() const { return all_; }
  std::int32_t entry(std::size_t block) const { return table_[block]; }
  const float* values(std::int32_t entry) const {
    return storage_.data() + static_cast<std::size_t>(entry) * kPoints;
  }
  float* values(std::int32_t entry) {
    return storage_.data() + static_cast<std::size_t>(entry) * kPoints;
  }

  /// Returns the value at a point; takes any integers.
  float At(int i, int j, int k) const noexcept;
  /// Interpolates trilinearly between the eight points round p, which is given in B.
  FieldSample Sample(const Vec3& p_B) const noexcept { return Sample(lattice_.PlaceOf(p_B)); }
  FieldSample Sample(const Lattice::Place& at) const noexcept;
  /// Returns the same distance, to the bit, without the gradient.
  double Distance(const Vec3& p_B) const noexcept { return Distance(lattice_.PlaceOf(p_B)); }
  double Distance(const Lattice::Place& at) const noexcept;

  /// Reserves storage for so many blocks.  Set-up.
  void Reserve(std::size_t blocks);
  std::size_t free_blocks() const { return free_.size(); }
  /// Gives storage to a block that has none, filled with the block's former value, and
  /// returns its entry.
  std::int32_t Acquire(std::size_t block) noexcept;
  /// Sets the entry of a block without storage.  Set-up.
  void Fill(std::size_t block, std::int32_t all) noexcept { table_[block] = all; }
  /// Takes back a block's storage, and sets its entry to `all`.
  void Release(std::size_t block, std::int32_t all) noexcept;

  /// Resets every block to its initial entry.  Real-time: goes through the table once.
  void Clear() noexcept;

  /// Returns the memory of this field, or of one with storage for so many blocks [bytes].
  std::size_t bytes() const { return BytesOf(lattice_.block_count(), stored_); }
  static std::size_t BytesOf(std::size_t blocks, std::size_t stored) {
    return blocks * sizeof(std::int32_t) +
           stored * (kPoints * sizeof(float) + sizeof(std::int32_t));
  }

 private:
  float ValueOf(std::int32_t entry, int point) const {
    return entry >= 0 ? values(entry)[point] : entry == kBelow ? -band_ : band_;
  }

  /// Reads the eight values round a place; false if all of them are v[0].
  bool Cell(const Lattice::Place& at, double v[8]) const noexcept;

  Lattice lattice_;
  float band_;
  std::int32_t all_;
  std::size_t stored_ = 0;
  std::vector<std::int32_t> table_;
  std::vector<float> storage_;
  RoomyVector<std::int32_t> free_;  ///< a stack
};

}  // namespace palpate
