#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "common/math/pose.h"
#include "server/physics/simd/kernels.h"
#include "server/physics/surface/contact_mesh.h"

namespace palpate {

/// A binary tree of convex hulls over the triangles of a ContactMesh.  It tells whether a whole
/// patch, the triangles below a node, lies on one side of a plane.  The hull of a small patch is
/// that of its corners; a larger patch has an oriented box (README.md).
/// A node is an index: inner nodes count from 0, the root; triangle t is ~t.
///
/// A tree over the blocks of a lattice has boxes only, and does not know what lies in a block's
/// box. Both children of block b's node are ~b.
class HullTree {
 public:
  using Node = std::int32_t;
  /// A box along the axes [m].
  struct Bounds {
    Vec3 low, high;
  };
  /// Scratch memory for making a tree, which may be reused.
  struct Scratch {
    /// Allocates what Assign needs for this many triangles.
    void Reserve(std::size_t triangles) { ReserveEach(triangles, order, bounds); }

    std::vector<std::uint32_t> order;  ///< the triangles; those of a patch are adjacent
    std::vector<std::pair<double, std::uint32_t>> places, dealt;
    std::vector<std::uint32_t> ends;
    std::vector<Bounds> bounds;  ///< for each triangle, if all boxes lie along the axes
  };
  struct Inner {
    Vec3 centre;    ///< centre of the patch's box [m]
    double radius;  ///< of a ball about the centre that holds the triangles below [m]
    Node child[2];
  };
  struct OrientedBox {
    Vec3 centre;  ///< [m]
    Mat3 sides;   ///< orthogonal columns, from the centre to three sides, the shortest first [m]
  };
  /// The hull of a node, in one of three forms: leaf, eights or box.
  struct Hull {
    const Mat3* leaf = nullptr;           ///< corners of a triangle [m]
    const EightPoints* eights = nullptr;  ///< corners of a patch that has few
    int count = 0;
    std::uint32_t lanes = 0;           ///< if there is one eight, its lanes that count
    const OrientedBox* box = nullptr;  ///< of a patch with more corners

    /// Returns the point that is lowest along m (any vector); of equally low points, the first.
    /// The choice is made without branches, because they could not be predicted.
    Vec3 Lowest(const Vec3& m, const Kernels& kernels) const;
  };

  HullTree() = default;
  /// `set`: if given, the root's children are the triangles in the set and the others,
  /// unless either is empty.
  explicit HullTree(const ContactMesh& mesh, const std::vector<bool>& set = {});
  /// Allocates storage for this many triangles.
  void Reserve(std::size_t triangles);
  /// Rebuilds the tree over the first `count` triangles, with boxes along the frame's axes.
  /// Real-time if the storage suffices.
  void Assign(const ContactMesh& mesh, std::size_t count, Scratch& scratch);
  struct Box {
    Vec3 low, high;  ///< [m]
    std::uint32_t block;
  };
  /// Makes a tree over the boxes of blocks, which lie along the frame's axes.
  explicit HullTree(std::span<Box> boxes);

  static bool IsLeaf(Node node) { return node < 0; }
  static std::uint32_t TriangleOf(Node node) { return static_cast<std::uint32_t>(~node); }
  Node root() const { return inner_.empty() ? ~0 : 0; }
  Node inner_count() const { return static_cast<Node>(inner_.size()); }
  std::size_t triangles() const { return leaf_radius_.size(); }
  /// Returns whether a number is one of the tree's nodes.
  bool Has(Node node) const {
    return IsLeaf(node) ? TriangleOf(node) < triangles() : node < inner_count();
  }
  const Inner& inner(Node node) const { return inner_[static_cast<std::size_t>(node)]; }
  /// Returns the block that a node stands for, or -1.
  std::int32_t BlockOf(Node node) const {
    if (IsLeaf(node)) return -1;
    const Node child = inner(node).child[0];
    return IsLeaf(child) && child == inner(node).child[1] ? ~child : -1;
  }
  bool IsOfBlocks() const { return leaf_radius_.empty() && !inner_.empty(); }
  /// The centre of a node, and the radius of a ball about it that holds what is below [m].
  const Vec3& Centre(Node node) const {
    return IsLeaf(node) ? leaf_centre_[TriangleOf(node)] : inner(node).centre;
  }
  double Radius(Node node) const {
    return IsLeaf(node) ? leaf_radius_[TriangleOf(node)] : inner(node).radius;
  }
  /// Returns whether, of two nodes that are not both triangles, this tree's node is to be split.
  bool IsLarger(Node node, const HullTree& than, Node other) const {
    return !IsLeaf(node) && (IsLeaf(other) || inner(node).radius >= than.inner(other).radius);
  }
  /// Returns the greatest n . x over a node's hull, with n any vector [|n| m].
  double Highest(Node node, const Vec3& n, const Kernels& kernels) const {
    if (!IsLeaf(node)) return n.dot(HullOf(node).Lowest(-n, kernels));
    const Mat3& x = leaf_corners_[TriangleOf(node)];
    return std::max(std::max(n.dot(x.col(0)), n.dot(x.col(1))), n.dot(x.col(2)));
  }
  Hull HullOf(Node node) const {
    if (IsLeaf(node)) return {.leaf = &leaf_corners_[TriangleOf(node)]};
    const Corners& corners = corners_[static_cast<std::size_t>(node)];
    if (corners.eights == 0) return {.box = &hulls_.boxes[corners.first]};
    return {.eights = hulls_.eights.data() + corners.first,
            .count = static_cast<int>(corners.eights),
            .lanes = corners.lanes};
  }

 private:
  /// Where the corners of an inner node's patch are stored: the given lanes of one eight, or all of
  /// several eights.  No eights if there are too many corners: `first` is the box then.
  struct Corners {
    std::uint32_t first, eights, lanes;
  };
  class Builder;

  Node AddBoxes(std::span<Box> boxes);

  std::vector<Inner> inner_;
  std::vector<Corners> corners_;  ///< for each inner node
  struct Hulls {
    /// The corners, in the order of the patches: a node shares those of the nodes below it.
    std::vector<EightPoints> eights;
    std::vector<OrientedBox> boxes;
  } hulls_;
  std::vector<Mat3> leaf_corners_;  ///< columns [m]: beside each other, for speed
  std::vector<Vec3> leaf_centre_;
  std::vector<double> leaf_radius_;
};

inline Vec3 HullTree::Hull::Lowest(const Vec3& m, const Kernels& kernels) const {
  if (leaf != nullptr) {
    const double along[3] = {m.dot(leaf->col(0)), m.dot(leaf->col(1)), m.dot(leaf->col(2))};
    const int first = along[1] < along[0] ? 1 : 0;
    return leaf->col(along[2] < along[first] ? 2 : first);
  }
  if (eights != nullptr) {
    const int best = kernels.lowest_point(eights, count, lanes, m.data());
    const EightPoints& eight = eights[best / 8];
    return {eight.x[0][best % 8], eight.x[1][best % 8], eight.x[2][best % 8]};
  }
  constexpr double kSign[2] = {-1.0, 1.0};
  Vec3 corner = box->centre;
  for (int c = 0; c < 3; ++c) {
    const Vec3 side = box->sides.col(c);
    corner += kSign[m.dot(side) < 0.0 ? 1 : 0] * side;
  }
  return corner;
}

}  // namespace palpate
