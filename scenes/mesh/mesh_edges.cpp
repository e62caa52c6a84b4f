#include "scenes/mesh/mesh_edges.h"

#include <algorithm>
#include <utility>

#include "common/math/sort_by_number.h"

namespace palpate {

EdgeSides::EdgeSides(std::span<const Corners> triangles, std::size_t vertices) {
  sides_.reserve(3 * triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    const auto& [i, j, k] = triangles[t];
    if (i == j || j == k || k == i) continue;
    for (const auto& [from, to] : {std::pair{i, j}, std::pair{j, k}, std::pair{k, i}}) {
      sides_.push_back({std::min(from, to), std::max(from, to), t, from < to});
    }
  }
  SortByNumber(sides_, vertices, &Side::high);
  SortByNumber(sides_, vertices, &Side::low);
}

std::vector<OpenEdge> OpenEdges(const TriangleMesh& mesh) {
  std::vector<OpenEdge> open;
  EdgeSides(mesh).ForEachEdge([&](std::span<const Side> sides) {
    if (sides.size() > 1) return;
    const Side& side = sides.front();
    open.push_back(
        {side.forward ? side.low : side.high, side.forward ? side.high : side.low, side.triangle});
  });
  return open;
}

std::vector<bool> FindRepeated(std::span<const Corners> triangles, std::size_t vertices) {
  struct Sorted {
    Corners corners;
    std::uint32_t triangle;
  };
  std::vector<Sorted> all;
  all.reserve(triangles.size());
  for (std::uint32_t t = 0; t < triangles.size(); ++t) {
    all.push_back({triangles[t], t});
    std::ranges::sort(all.back().corners);
  }
  for (const std::size_t c : {2u, 1u, 0u}) {
    SortByNumber(all, vertices, [c](const Sorted& sorted) { return sorted.corners[c]; });
  }
  std::vector<bool> repeated(triangles.size(), false);
  for (std::size_t i = 1; i < all.size(); ++i) {
    repeated[all[i].triangle] = all[i].corners == all[i - 1].corners;
  }
  return repeated;
}

}  // namespace palpate
