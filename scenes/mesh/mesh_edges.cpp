#include "scenes/mesh/mesh_edges.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace palpate {

std::vector<OpenEdge> OpenEdges(const TriangleMesh& mesh) {
  std::vector<OpenEdge> edges;
  edges.reserve(3 * mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [i, j, k] = mesh.triangles[t];
    if (i == j || j == k || k == i) continue;
    for (const auto& [from, to] : {std::pair{i, j}, std::pair{j, k}, std::pair{k, i}}) {
      edges.push_back({from, to, t});
    }
  }
  const auto ends = [](const OpenEdge& e) { return std::minmax(e.from, e.to); };
  std::sort(edges.begin(), edges.end(), [&](const OpenEdge& a, const OpenEdge& b) {
    return std::tuple(std::pair(ends(a)), a.triangle) < std::tuple(std::pair(ends(b)), b.triangle);
  });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i + 1;
    while (end < edges.size() && ends(edges[end]) == ends(edges[i])) ++end;
    if (end - i == 1) edges[kept++] = edges[i];
    i = end;
  }
  edges.resize(kept);
  return edges;
}

}  // namespace palpate
