#pragma once

#include <cstdint>
#include <vector>

#include "server/physics/simd/kernels.h"

namespace palpate {

class ObjectForest;

/// How worn the leaves of a scene's objects are, as one tool has them (chapter 2.5.6): the scraping
/// work that each still stands, and which have gone.  A leaf that has gone is in nobody's way.
/// A value: copied, it goes on alike.  Empty where the scene declares no removal; nothing wears
/// then.
class LeafWear {
 public:
  LeafWear() = default;
  /// All leaves whole.  Allocates; nothing after it does.
  explicit LeafWear(const ObjectForest& objects);

  std::size_t leaf_count() const { return left_.size(); }  ///< 0 where nothing wears
  int gone_count() const { return gone_count_; }
  bool gone(int leaf) const {
    const auto i = static_cast<std::size_t>(leaf);
    return gone_count_ != 0 && (gone_[i / 64] >> (i % 64) & 1u) != 0;
  }
  /// Work that the leaf still stands [J]; infinite where it does not wear.
  double hardness_left(int leaf) const { return left_[static_cast<std::size_t>(leaf)]; }

  /// Spends work on a leaf; true where that makes it vanish.  Real-time.
  bool Scrape(int leaf, double work) noexcept;
  /// Takes a leaf away at once: what an event says.  False where it had gone, or nothing wears
  /// here. Real-time.
  bool Remove(int leaf) noexcept;
  /// Moves the pairs whose object leaf is there to the front, in their order; returns how many.
  /// Real-time.
  int KeepPresent(NodePair* pairs, int count) const noexcept;

  bool operator==(const LeafWear&) const = default;

 private:
  std::vector<double> left_;
  std::vector<std::uint64_t> gone_;  ///< a bit per leaf
  int gone_count_ = 0;
};

}  // namespace palpate
