#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace palpate {

/// The numbers 0 to count - 1, each in its own set until sets are joined (union-find).
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0u);
  }
  /// Returns the number that represents the set of v.
  std::uint32_t Find(std::uint32_t v) {
    while (parent_[v] != v) v = parent_[v] = parent_[parent_[v]];
    return v;
  }
  void Join(std::uint32_t a, std::uint32_t b) { parent_[Find(a)] = Find(b); }

 private:
  std::vector<std::uint32_t> parent_;
};

}  // namespace palpate
