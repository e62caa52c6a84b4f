#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "scenes/sphere_tree.h"
#include "server/physics/limits.h"
#include "server/physics/simd/kernels.h"
#include "server/physics/step_types.h"

namespace palpate {

/// The levels of a packet tree, stored one after the other; a child index counts
/// within the next level.
template <class Packet>
struct PacketLevels {
  std::vector<Packet> packets;
  std::vector<std::int32_t> level_begin;  ///< levels + 1 entries
  int levels() const { return static_cast<int>(level_begin.size()) - 1; }
};

/// Depth of a soft leaf's rigid core (limits::kSoftShare) below the leaf's surface [m]; 0 if
/// the material is rigid.
inline double CoreDepth(const Material& material, double leaf_radius) {
  return std::isinf(material.stiffness) ? 0.0 : limits::kSoftShare * leaf_radius;
}

/// All objects of a scene as one tree in W: a few levels over the objects, then their own trees.
/// Immutable once made.
struct ObjectForest {
  /// `touches`: selects the objects whose leaves can touch; null: all.
  explicit ObjectForest(std::span<const PlacedTree> objects,
                        bool (*touches)(const PlacedTree&) = nullptr);

  const Material& MaterialOf(int leaf) const {
    return materials[leaf_material[static_cast<std::size_t>(leaf)]];
  }

  PacketLevels<SpherePacket> levels;
  std::vector<LeafSphere> leaves;  ///< in W
  std::vector<int> first_leaf;     ///< for each object
  std::vector<Material> materials;
  std::vector<std::uint32_t> leaf_material;  ///< for each leaf, index into `materials`
  bool any = false;                          ///< whether any leaf can touch anything
  bool yields = false;                       ///< whether any leaf is soft
  /// A packet with one lane around everything, whose only child is packet 0.  It stands above this
  /// tree if the tool's tree is deeper, so that both always descend together.
  SpherePacket above;
  Vec3 center = Vec3::Zero();  ///< of a ball around everything [m]
  double radius = 0.0;

 private:
  void AddMaterials(const PlacedTree& object);
};

/// The tool's tree, relative to its reference point, with the longest lever arm below each node.
/// Levers end at the centres of leaves, because a ball turns in place.  Immutable once made.
struct ToolTree {
  /// `world_extent`: how far the objects reach from W's origin [m], for the rounding margin
  ToolTree(const SphereTree& tree, double world_extent);

  PacketLevels<ToolPacket> levels;
  std::vector<LeafSphere> leaves;
  ToolPacket above;  ///< as ObjectForest::above
  /// Reference point of the step, in the tool's frame: the centroid, or the centre of a single
  /// sphere.
  Vec3 reference;
  double max_lever = 0.0;
  double reach = 0.0;  ///< distance from the reference point to the farthest point of any leaf [m]
};

/// Finds every pair of leaves that a sub-step within given bounds could bring together: those with
/// a gap of at most bounds.translation + bounds.rotation * lever of the tool's leaf.
/// Walks both trees level by level, and depth first a chunk of pairs at a time, so that no list can
/// overflow.  The order of the pairs depends on the trees alone.
class PairQuery {
 public:
  PairQuery(const ToolTree& tool, const ObjectForest& objects);

  /// Calls sink(NodePair* leaves, int count) with batches of at most kMaxBatch leaf pairs, which it
  /// may overwrite, as long as it returns true.  No pair is missed; a margin for float rounding may
  /// add a few.  Real-time: no allocation.
  template <class Sink>
  void Run(const Kernels& kernels, const Mat3& R_WG, const Vec3& p_W, const StepBounds& bounds,
           Sink&& sink) noexcept;

  /// Packet pairs tested since construction: a measure of cost.
  std::int64_t tested() const { return tested_; }

  static constexpr int kChunk = kMaxExpanded;
  static constexpr int kMaxBatch = kChunk * kTreeArity * kTreeArity;

 private:
  template <class Sink>
  bool Descend(const Kernels& kernels, int level, const NodePair* pairs, int count,
               Sink& sink) noexcept;

  std::vector<LevelView> views_;
  std::vector<WorldPacket> world_;
  std::vector<std::uint32_t> stamps_;
  std::vector<NodePair> lists_;  ///< kMaxBatch per level
  QueryPose pose_{};
  std::uint32_t now_ = 0;
  std::int64_t tested_ = 0;
};

template <class Sink>
void PairQuery::Run(const Kernels& kernels, const Mat3& R_WG, const Vec3& p_W,
                    const StepBounds& bounds, Sink&& sink) noexcept {
  for (int r = 0; r < 3; ++r) {
    pose_.p[r] = static_cast<float>(p_W[r]);
    for (int c = 0; c < 3; ++c) pose_.R[3 * r + c] = static_cast<float>(R_WG(r, c));
  }
  // The margin of the radii covers the rounding of these two.
  pose_.max_translation = static_cast<float>(bounds.translation);
  pose_.max_rotation = static_cast<float>(bounds.rotation);
  if (++now_ == 0) {  // wrapped after 2^32 queries: forget all stamps
    std::fill(stamps_.begin(), stamps_.end(), 0u);
    now_ = 1;
  }
  const NodePair root{0, 0};
  Descend(kernels, 0, &root, 1, sink);
}

template <class Sink>
bool PairQuery::Descend(const Kernels& kernels, int level, const NodePair* pairs, int count,
                        Sink& sink) noexcept {
  tested_ += count;
  NodePair* out = lists_.data() + static_cast<std::size_t>(level) * kMaxBatch;
  for (int i = 0; i < count; i += kChunk) {
    const int chunk = std::min(kChunk, count - i);
    const int found = kernels.expand_pairs(views_[level], pose_, now_, pairs + i, chunk, out);
    if (found == 0) continue;
    if (level + 1 == static_cast<int>(views_.size())) {
      if (!sink(out, found)) return false;
    } else if (!Descend(kernels, level + 1, out, found, sink)) {
      return false;
    }
  }
  return true;
}

}  // namespace palpate
