#include "server/physics/tree/leaf_wear.h"

#include <string>

#include "common/error.h"
#include "server/physics/tree/sphere_tree_query.h"

namespace palpate {

LeafWear::LeafWear(const ObjectForest& objects) {
  for (int i = 0; i < objects.leaf_count(); ++i) {
    const double hardness = objects.MaterialOf(i).hardness;
    if (!(hardness > 0.0)) {
      throw Error("materials: hardness " + std::to_string(hardness) + " J of object " +
                  std::to_string(objects.ObjectOf(i)) +
                  "; give a positive number, or none for what stays");
    }
    left_.push_back(hardness);
  }
  gone_.resize((left_.size() + 63) / 64);
}

bool LeafWear::Scrape(int leaf, double work) noexcept {
  if (static_cast<std::size_t>(leaf) >= left_.size()) return false;
  double& left = left_[static_cast<std::size_t>(leaf)];
  left -= work;
  return left <= 0.0 && Remove(leaf);
}

bool LeafWear::Remove(int leaf) noexcept {
  const auto i = static_cast<std::size_t>(leaf);
  if (i >= left_.size() || gone(leaf)) return false;
  gone_[i / 64] |= std::uint64_t{1} << (i % 64);
  left_[i] = 0.0;
  ++gone_count_;
  return true;
}

int LeafWear::KeepPresent(NodePair* pairs, int count) const noexcept {
  if (gone_count_ == 0) return count;
  int kept = 0;
  for (int i = 0; i < count; ++i) {
    if (!gone(pairs[i].object)) pairs[kept++] = pairs[i];
  }
  return kept;
}

}  // namespace palpate
