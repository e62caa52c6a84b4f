#pragma once

#include <algorithm>
#include <cstdint>
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
/// A node is an index: inner nodes from 0, the root; triangle t is ~t.  Immutable.
class HullTree {
 public:
  using Node = std::int32_t;
  struct Inner {
    Vec3 centre;    ///< of the box [m]
    Mat3 sides;     ///< columns, orthogonal: from there to three sides, the shortest first [m]
    double radius;  ///< of the ball about the centre that holds the triangles below [m]
    Node child[2];
  };

  HullTree() = default;
  explicit HullTree(const ContactMesh& mesh);

  static bool IsLeaf(Node node) { return node < 0; }
  static std::uint32_t TriangleOf(Node node) { return static_cast<std::uint32_t>(~node); }
  Node root() const { return inner_.empty() ? ~0 : 0; }
  const Inner& inner(Node node) const { return inner_[static_cast<std::size_t>(node)]; }
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
    if (!IsLeaf(node)) return n.dot(Lowest(node, -n, kernels));
    const Mat3& x = leaf_corners_[TriangleOf(node)];
    return std::max(std::max(n.dot(x.col(0)), n.dot(x.col(1))), n.dot(x.col(2)));
  }
  /// The point of a node's hull that is lowest along m, any vector; of two as low the first.
  Vec3 Lowest(Node node, const Vec3& m, const Kernels& kernels) const;

 private:
  /// Where the corners of an inner node's patch are: those of its lanes if it has one eight, else
  /// all of several; none where they are too many, and the box counts.
  struct Corners {
    std::uint32_t first, eights, lanes;
  };
  class Builder;

  std::vector<Inner> inner_;
  std::vector<Corners> corners_;  ///< of each inner node
  /// Corners beside each other as their patches are: a node shares those of the nodes below it.
  std::vector<EightPoints> points_;
  std::vector<Mat3> leaf_corners_;  ///< columns [m]: beside each other, for speed
  std::vector<Vec3> leaf_centre_;
  std::vector<double> leaf_radius_;
};

}  // namespace palpate
