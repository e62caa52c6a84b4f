#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/math/pose.h"
#include "server/physics/simd/kernels.h"
#include "server/physics/surface/contact_mesh.h"

namespace palpate {

/// A binary tree of oriented boxes over the triangles of a ContactMesh, which tells whether a whole
/// patch, the triangles below a node, lies on one side of a plane (Gottschalk, Lin & Manocha,
/// SIGGRAPH 1996).  A patch that bends little is thin in its own box; a ball round it is as thick
/// as it is wide.  So two surfaces that run beside each other are told apart by a few wide patches,
/// not by many pairs of triangles.
/// A node is an index: inner nodes from 0, the root; triangle t is ~t.  Immutable.
class BoxTree {
 public:
  using Node = std::int32_t;
  struct Box {
    Vec3 centre;    ///< [m]
    Mat3 sides;     ///< columns, orthogonal: from the centre to three sides, the shortest first [m]
    double radius;  ///< of the ball about the centre that holds the triangles below [m]
    double scale;   ///< 1 over the length of the shortest side; 0 for a point
    Node parent;    ///< -1 for the root
    Node child[2];

    /// Unit normal of the widest side; zero for a point.
    Vec3 Flattest() const { return scale * sides.col(0); }
  };

  BoxTree() = default;
  explicit BoxTree(const ContactMesh& mesh);

  static bool IsLeaf(Node node) { return node < 0; }
  static std::uint32_t TriangleOf(Node node) { return static_cast<std::uint32_t>(~node); }
  Node root() const { return boxes_.empty() ? ~0 : 0; }
  const Box& box(Node node) const { return boxes_[static_cast<std::size_t>(node)]; }
  Node Parent(Node node) const {
    return IsLeaf(node) ? leaf_parent_[TriangleOf(node)] : box(node).parent;
  }
  /// Centre of a node, and radius about it of a ball that holds what is below [m].
  const Vec3& Centre(Node node) const {
    return IsLeaf(node) ? leaf_centre_[TriangleOf(node)] : box(node).centre;
  }
  double Radius(Node node) const {
    return IsLeaf(node) ? leaf_radius_[TriangleOf(node)] : box(node).radius;
  }
  /// Of a pair that is not of two triangles, whether this tree's node is the one to be opened.
  bool IsLarger(Node node, const BoxTree& than, Node other) const {
    return !IsLeaf(node) && (IsLeaf(other) || box(node).radius >= than.box(other).radius);
  }
  /// As the kernels take it.
  Piece PieceOf(Node node) const {
    if (IsLeaf(node)) return {leaf_corners_[TriangleOf(node)].data(), true};
    static_assert(offsetof(Box, sides) == 3 * sizeof(double));
    return {box(node).centre.data(), false};
  }
  /// The most of n . x over what is below a node, n any vector [|n| m].
  double Highest(Node node, const Vec3& n) const {
    if (IsLeaf(node)) {
      const Mat3& x = leaf_corners_[TriangleOf(node)];
      return std::max(std::max(n.dot(x.col(0)), n.dot(x.col(1))), n.dot(x.col(2)));
    }
    const Box& b = box(node);
    return n.dot(b.centre) + (b.sides.transpose() * n).cwiseAbs().sum();
  }

 private:
  std::vector<Box> boxes_;
  std::vector<Node> leaf_parent_;
  std::vector<Mat3> leaf_corners_;  ///< columns [m]: beside each other, for speed
  std::vector<Vec3> leaf_centre_;
  std::vector<double> leaf_radius_;
};

}  // namespace palpate
