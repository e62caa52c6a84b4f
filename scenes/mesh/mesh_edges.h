#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "scenes/scene.h"

namespace palpate {

/// Numbers of a triangle's vertices.
using Corners = std::array<std::uint32_t, 3>;

/// An edge as one of its triangles has it.
struct Side {
  std::uint32_t low, high;  ///< its ends, the lower number first
  std::uint32_t triangle;
  bool forward;  ///< the triangle runs from low to high
};

/// The sides of triangles, those of one edge beside each other.  Triangles with a corner twice have
/// none.
class EdgeSides {
 public:
  /// @param vertices  how many there are: above every corner.
  EdgeSides(std::span<const Corners> triangles, std::size_t vertices);
  explicit EdgeSides(const TriangleMesh& mesh) : EdgeSides(mesh.triangles, mesh.vertices.size()) {}

  /// Calls `work` with each edge's sides, a span, in the order of their triangles.  Edges come in
  /// the order of their lower, then of their higher ends.
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

/// An edge of one triangle only, which runs along it that way.
struct OpenEdge {
  std::uint32_t from, to, triangle;
};

/// In the order of EdgeSides.
std::vector<OpenEdge> OpenEdges(const TriangleMesh& mesh);

/// Which triangles have the same corners, in any order, as one before them.
std::vector<bool> FindRepeated(std::span<const Corners> triangles, std::size_t vertices);

}  // namespace palpate
