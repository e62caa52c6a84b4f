#include "scenes/mesh_orient.h"

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "scenes/mesh_report.h"

namespace palpate {
namespace {

struct Neighbour {
  std::uint32_t triangle;
  bool agrees;  ///< runs along the shared edge the other way, as it should
};

/// Each triangle's neighbours over edges of exactly two triangles.
std::vector<std::vector<Neighbour>> FindNeighbours(const TriangleMesh& mesh) {
  struct Side {
    std::uint32_t low, high, triangle;
    bool forward;
  };
  std::vector<Side> sides;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [i, j, k] = mesh.triangles[t];
    if (i == j || j == k || k == i) continue;
    for (const auto& [from, to] : {std::pair{i, j}, std::pair{j, k}, std::pair{k, i}}) {
      sides.push_back({std::min(from, to), std::max(from, to), t, from < to});
    }
  }
  const auto key = [](const Side& s) { return std::array{s.low, s.high, s.triangle}; };
  std::sort(sides.begin(), sides.end(),
            [&](const Side& a, const Side& b) { return key(a) < key(b); });
  std::vector<std::vector<Neighbour>> neighbours(mesh.triangles.size());
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i;
    while (end < sides.size() && sides[end].low == sides[i].low &&
           sides[end].high == sides[i].high) {
      ++end;
    }
    if (end - i == 2) {
      const bool agrees = sides[i].forward != sides[i + 1].forward;
      neighbours[sides[i].triangle].push_back({sides[i + 1].triangle, agrees});
      neighbours[sides[i + 1].triangle].push_back({sides[i].triangle, agrees});
    }
    i = end;
  }
  return neighbours;
}

}  // namespace

std::size_t OrientTriangles(TriangleMesh& mesh) {
  const auto neighbours = FindNeighbours(mesh);
  std::vector<bool> turned(mesh.triangles.size(), false);
  std::vector<bool> seen(mesh.triangles.size(), false);
  for (std::uint32_t start = 0; start < mesh.triangles.size(); ++start) {
    if (seen[start]) continue;
    seen[start] = true;
    std::vector<std::uint32_t> patch{start};
    double area[2] = {0.0, 0.0};  // as it was, turned
    for (std::size_t next = 0; next < patch.size(); ++next) {
      const std::uint32_t t = patch[next];
      const auto& [i, j, k] = mesh.triangles[t];
      const Vec3& a = mesh.vertices[i];
      area[turned[t]] += (mesh.vertices[j] - a).cross(mesh.vertices[k] - a).norm();
      for (const Neighbour& n : neighbours[t]) {
        if (seen[n.triangle]) continue;
        seen[n.triangle] = true;
        turned[n.triangle] = turned[t] == n.agrees;
        patch.push_back(n.triangle);
      }
    }
    if (area[1] <= area[0]) continue;
    for (std::uint32_t t : patch) turned[t] = !turned[t];
  }
  const auto turn = [&](std::uint32_t t) { std::swap(mesh.triangles[t][1], mesh.triangles[t][2]); };
  for (std::uint32_t t = 0; t < turned.size(); ++t) {
    if (turned[t]) turn(t);
  }
  if (InspectMesh(mesh).inside_out()) {
    for (std::uint32_t t = 0; t < turned.size(); ++t) {
      turn(t);
      turned[t] = !turned[t];
    }
  }
  return std::count(turned.begin(), turned.end(), true);
}

}  // namespace palpate
