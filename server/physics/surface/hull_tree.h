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

/// A binary tree of convex hulls over the triangles of a ContactMesh, which tells whether a whole
/// patch, the triangles below a node, lies on one side of a plane (Ehmann & Lin, Computer Graphics
/// Forum 20 (2001) 500-510).  The hull of a small patch is that of its corners; a larger one has
/// an oriented box, for a patch that bends little is thin in its own box (Gottschalk, Lin &
/// Manocha, SIGGRAPH 1996).  So two surfaces that run beside each other are told apart by a few
/// wide patches, not by many pairs of triangles.
/// A node is an index: inner nodes from 0, the root; triangle t is ~t.
///
/// A tree over the blocks of a lattice has boxes alone.  What lies in a block's box is not known to
/// it: both children of a block b's node are ~b.
class HullTree {
 public:
  using Node = std::int32_t;
  /// Along the axes of a box [m].
  struct Bounds {
    Vec3 low, high;
  };
  /// What making one takes, which may be used again.
  struct Scratch {
    /// For Assign.
    void Reserve(std::size_t triangles);

    std::vector<std::uint32_t> order;  ///< the triangles, those of a patch beside each other
    std::vector<std::pair<double, std::uint32_t>> places, dealt;
    std::vector<std::uint32_t> ends;
    std::vector<Bounds> bounds;  ///< of each triangle, where all boxes have the same axes
  };
  struct Inner {
    Vec3 centre;    ///< of the box [m]
    Mat3 sides;     ///< columns, orthogonal: from there to three sides, the shortest first [m]
    double radius;  ///< of a ball about the centre that holds the triangles below [m]
    Node child[2];
  };
  /// The hull of a node: one of the three.
  struct Hull {
    const Mat3* leaf = nullptr;           ///< its corners [m]
    const EightPoints* eights = nullptr;  ///< the corners of a patch, where they are few
    int count = 0;
    std::uint32_t lanes = 0;     ///< of one eight, those that count
    const Inner* box = nullptr;  ///< of a patch that has more

    /// The point that is lowest along m, any vector; of two as low the first.  Without branches on
    /// which it is: that cannot be foretold.
    Vec3 Lowest(const Vec3& m, const Kernels& kernels) const;
  };

  HullTree() = default;
  /// `set`: the root's children are the triangles in it and those that are not, where there are
  /// both.
  explicit HullTree(const ContactMesh& mesh, const std::vector<bool>& set = {});
  /// Storage for so many triangles.
  void Reserve(std::size_t triangles);
  /// Makes the tree anew over the first `count` triangles, with boxes along the columns of a
  /// rotation.  Real-time within the storage.
  void Assign(const ContactMesh& mesh, std::size_t count, const Mat3& axes, Scratch& scratch);
  struct Box {
    Vec3 low, high;  ///< B [m]
    std::uint32_t block;
  };
  /// Boxes of blocks, along the axes of B.
  HullTree(std::span<Box> boxes, const Pose& X_FB);

  static bool IsLeaf(Node node) { return node < 0; }
  static std::uint32_t TriangleOf(Node node) { return static_cast<std::uint32_t>(~node); }
  Node root() const { return inner_.empty() ? ~0 : 0; }
  Node inner_count() const { return static_cast<Node>(inner_.size()); }
  const Inner& inner(Node node) const { return inner_[static_cast<std::size_t>(node)]; }
  /// The block whose node it is; -1 of any other.
  std::int32_t BlockOf(Node node) const {
    if (IsLeaf(node)) return -1;
    const Node child = inner(node).child[0];
    return IsLeaf(child) && child == inner(node).child[1] ? ~child : -1;
  }
  bool IsOfBlocks() const { return leaf_radius_.empty() && !inner_.empty(); }
  /// Centre of a node, and radius about it of a ball that holds what is below [m].
  const Vec3& Centre(Node node) const {
    return IsLeaf(node) ? leaf_centre_[TriangleOf(node)] : inner(node).centre;
  }
  double Radius(Node node) const {
    return IsLeaf(node) ? leaf_radius_[TriangleOf(node)] : inner(node).radius;
  }
  /// Of a pair that is not of two triangles, whether this tree's node is the one to be opened.
  bool IsLarger(Node node, const HullTree& than, Node other) const {
    return !IsLeaf(node) && (IsLeaf(other) || inner(node).radius >= than.inner(other).radius);
  }
  /// The most of n . x over a node's hull, n any vector [|n| m].
  double Highest(Node node, const Vec3& n, const Kernels& kernels) const {
    if (!IsLeaf(node)) return n.dot(HullOf(node).Lowest(-n, kernels));
    const Mat3& x = leaf_corners_[TriangleOf(node)];
    return std::max(std::max(n.dot(x.col(0)), n.dot(x.col(1))), n.dot(x.col(2)));
  }
  Hull HullOf(Node node) const {
    if (IsLeaf(node)) return {.leaf = &leaf_corners_[TriangleOf(node)]};
    const Corners& corners = corners_[static_cast<std::size_t>(node)];
    if (corners.eights == 0) return {.box = &inner(node)};
    return {.eights = points_.data() + corners.first,
            .count = static_cast<int>(corners.eights),
            .lanes = corners.lanes};
  }

 private:
  /// Where the corners of an inner node's patch are: those of its lanes if it has one eight, else
  /// all of several; none where they are too many, and the box counts.
  struct Corners {
    std::uint32_t first, eights, lanes;
  };
  class Builder;

  Node AddBoxes(std::span<Box> boxes, const Pose& X_FB);

  std::vector<Inner> inner_;
  std::vector<Corners> corners_;  ///< of each inner node
  /// Corners beside each other as their patches are: a node shares those of the nodes below it.
  std::vector<EightPoints> points_;
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
