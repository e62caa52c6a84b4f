#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "scenes/scene.h"

namespace palpate {

/// Indices of a triangle's vertices.
using Corners = std::array<std::uint32_t, 3>;

/// An edge as a side of one of its triangles.
struct Side {
  std::uint32_t low, high;  ///< its ends, the lower number first
  std::uint32_t triangle;
  bool forward;  ///< whether the triangle runs from low to high
};

/// The sides of all triangles, grouped by edge.  A triangle that has a corner twice has no sides.
class EdgeSides {
 public:
  /// @param vertices  the number of vertices: greater than every index.
  EdgeSides(std::span<const Corners> triangles, std::size_t vertices);
  explicit EdgeSides(const TriangleMesh& mesh) : EdgeSides(mesh.triangles, mesh.vertices.size()) {}

  /// Calls `work` with a span of the sides of each edge, in the order of their triangles.  Edges
  /// come in ascending order of `low`, then of `high`.
  template <class Work>
  void ForEachEdge(const Work& work) const {
    const std::span<const Side> sides(sides_);
    for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
      const Side& first = sides[begin];
      while (end < sides.size() && sides[end].low == first.low && sides[end].high == first.high) {
        ++end;
      }
      work(sides.subspan(begin, end - begin));
    }
  }

 private:
  std::vector<Side> sides_;
};

/// An edge that has only one triangle, in that triangle's direction.
struct OpenEdge {
  std::uint32_t from, to, triangle;
};

/// Returns the open edges, in the order of EdgeSides.
std::vector<OpenEdge> OpenEdges(const TriangleMesh& mesh);

/// Returns for each triangle whether an earlier one has the same corners, in any order.
std::vector<bool> FindRepeated(std::span<const Corners> triangles, std::size_t vertices);

}  // namespace palpate
