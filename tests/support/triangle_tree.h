#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/math/pose.h"
#include "scenes/scene.h"
#include "tests/support/triangle_overlap.h"

namespace palpate::test {

/// A mesh's triangles in a binary tree of boxes, halved at the median of the longest axis.
class TriangleTree {
 public:
  explicit TriangleTree(const TriangleMesh& mesh);

  struct Box {
    Vec3 center = Vec3::Zero(), half = Vec3::Constant(-INFINITY);
    bool Overlaps(const Box& other) const {
      return ((center - other.center).cwiseAbs() - half - other.half).maxCoeff() <= 0.0;
    }
    double Distance(const Box& other) const {
      return ((center - other.center).cwiseAbs() - half - other.half).cwiseMax(0.0).norm();
    }
  };
  static Box BoxOf(std::span<const Vec3> points);
  struct Node {
    Box box;
    std::int32_t child = -1;           ///< index of the first of two adjacent children; < 0: a leaf
    std::uint32_t begin = 0, end = 0;  ///< range in order()
    bool leaf() const { return child < 0; }
  };
  bool empty() const { return order_.empty(); }
  const Node& root() const { return nodes_.front(); }
  const Node& first(const Node& node) const { return nodes_[static_cast<std::size_t>(node.child)]; }
  const Node& second(const Node& node) const {
    return nodes_[static_cast<std::size_t>(node.child) + 1];
  }
  /// Indices of the mesh's triangles, grouped by node.
  std::span<const std::uint32_t> order() const { return order_; }
  std::span<const std::uint32_t> TrianglesOf(const Node& node) const {
    return order().subspan(node.begin, node.end - node.begin);
  }

  const std::vector<Vec3>& vertices() const { return vertices_; }
  const std::array<std::uint32_t, 3>& corners(std::uint32_t triangle) const {
    return triangles_[triangle];
  }
  std::size_t triangles() const { return triangles_.size(); }
  Triangle At(std::uint32_t triangle) const {
    const auto& t = triangles_[triangle];
    return {vertices_[t[0]], vertices_[t[1]], vertices_[t[2]]};
  }

  /// Returns true if every edge is used equally often in both directions, with coincident vertices
  /// counted as one: the winding number is then an integer at every point off the mesh.
  bool closed() const { return closed_; }
  /// Returns exactly whether a closed mesh has a nonzero winding number at p; false on its surface.
  bool Contains(const Vec3& p) const;

  /// Finds the nearest point of the surface, in doubles.
  /// @returns the distance; infinite if no triangle is nearer than `within`.
  double Distance(const Vec3& p, double within, Vec3* nearest = nullptr) const;

 private:
  void Build(std::size_t node, std::vector<Vec3>& centroids);
  bool IsClosed() const;

  std::vector<Vec3> vertices_;
  std::vector<std::array<std::uint32_t, 3>> triangles_;
  std::vector<Node> nodes_;
  std::vector<std::uint32_t> order_;
  bool closed_ = false;
};

}  // namespace palpate::test
