#include "scenes/mesh/mesh_pieces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "scenes/mesh/disjoint_sets.h"

namespace palpate {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

/// Calls `work` with the triangles at each edge, in the order of their numbers.
template <class Work>
void ForEachEdge(const TriangleMesh& mesh, const Work& work) {
  using Side = std::array<std::uint32_t, 3>;  // lower end, higher end, triangle
  std::vector<Side> sides;
  sides.reserve(3 * mesh.triangles.size());
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [i, j, k] = mesh.triangles[t];
    if (i == j || j == k || k == i) continue;
    for (const auto& [a, b] : {std::pair{i, j}, std::pair{j, k}, std::pair{k, i}}) {
      sides.push_back({std::min(a, b), std::max(a, b), t});
    }
  }
  std::ranges::sort(sides);
  std::vector<std::uint32_t> triangles;
  for (std::size_t i = 0; i < sides.size();) {
    const std::size_t begin = i;
    triangles.clear();
    for (; i < sides.size() && sides[i][0] == sides[begin][0] && sides[i][1] == sides[begin][1];
         ++i) {
      triangles.push_back(sides[i][2]);
    }
    work(triangles);
  }
}

/// Patches each of whose edges is one of two of its triangles, or of four: by their numbers.
std::vector<bool> ClosedPatches(const TriangleMesh& mesh, const std::vector<std::uint32_t>& patch) {
  std::vector<bool> closed(mesh.triangles.size(), false), open = closed;
  std::vector<std::uint32_t> at_edge;
  ForEachEdge(mesh, [&](const std::vector<std::uint32_t>& triangles) {
    at_edge.clear();
    for (const std::uint32_t t : triangles) at_edge.push_back(patch[t]);
    for (const std::uint32_t p : at_edge) {
      closed[p] = true;  // one that has no edges at all is not
      if (std::ranges::count(at_edge, p) % 2 == 1) open[p] = true;
    }
  });
  for (std::size_t p = 0; p < closed.size(); ++p) closed[p] = closed[p] && !open[p];
  return closed;
}

}  // namespace

std::vector<std::uint32_t> PatchesOf(const TriangleMesh& mesh) {
  DisjointSets patches(mesh.triangles.size());
  ForEachEdge(mesh, [&](const std::vector<std::uint32_t>& triangles) {
    if (triangles.size() == 2) patches.Join(triangles[0], triangles[1]);
  });
  std::vector<std::uint32_t> number(mesh.triangles.size(), kNone), of(mesh.triangles.size());
  std::uint32_t count = 0;
  for (std::uint32_t t = 0; t < of.size(); ++t) {
    std::uint32_t& patch = number[patches.Find(t)];
    if (patch == kNone) patch = count++;
    of[t] = patch;
  }
  return of;
}

std::vector<MeshPiece> PiecesOf(const TriangleMesh& mesh) {
  const std::vector<std::uint32_t> patch = PatchesOf(mesh);
  const std::vector<bool> closed = ClosedPatches(mesh, patch);
  DisjointSets vertices(mesh.vertices.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (closed[patch[t]]) continue;
    const auto& [i, j, k] = mesh.triangles[t];
    vertices.Join(i, j);
    vertices.Join(j, k);
  }
  std::vector<std::uint32_t> of_patch(mesh.triangles.size(), kNone);
  std::vector<std::uint32_t> of_vertex(mesh.vertices.size(), kNone);
  std::vector<std::uint32_t> number;
  std::uint32_t pieces = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::uint32_t& piece =
        closed[patch[t]] ? of_patch[patch[t]] : of_vertex[vertices.Find(mesh.triangles[t][0])];
    if (piece == kNone) piece = pieces++;
    number.push_back(piece);
  }
  return PiecesBy(mesh, number);
}

std::vector<MeshPiece> PiecesBy(const TriangleMesh& mesh,
                                const std::vector<std::uint32_t>& number) {
  std::vector<MeshPiece> pieces;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (number[t] >= pieces.size()) pieces.resize(number[t] + 1);
    pieces[number[t]].triangle.push_back(t);
  }
  // Only one piece has numbers for the vertices at a time.
  std::vector<std::uint32_t> piece_of(mesh.vertices.size(), kNone);
  std::vector<std::uint32_t> renamed(mesh.vertices.size());
  for (std::uint32_t n = 0; n < pieces.size(); ++n) {
    MeshPiece& piece = pieces[n];
    for (const std::uint32_t t : piece.triangle) {
      auto corners = mesh.triangles[t];
      for (std::uint32_t& v : corners) {
        if (piece_of[v] != n) {
          piece_of[v] = n;
          renamed[v] = static_cast<std::uint32_t>(piece.vertex.size());
          piece.vertex.push_back(v);
          piece.mesh.vertices.push_back(mesh.vertices[v]);
        }
        v = renamed[v];
      }
      piece.mesh.triangles.push_back(corners);
    }
    piece.report = InspectMesh(piece.mesh);
  }
  return pieces;
}

double Enclosure(const TriangleMesh& piece, const MeshQuery& whole) {
  constexpr std::size_t kMostSamples = 500;
  constexpr double kBehind = 1e-3;  // of a triangle's size
  double sum = 0.0, total = 0.0;
  const std::size_t count = piece.triangles.size();
  for (std::size_t t = 0; t < count; t += 1 + count / kMostSamples) {
    const auto& [i, j, k] = piece.triangles[t];
    const Vec3& a = piece.vertices[i];
    const Vec3 normal = (piece.vertices[j] - a).cross(piece.vertices[k] - a);
    const double area = 0.5 * normal.norm();
    if (!(area > 0.0)) continue;
    const Vec3 middle = (a + piece.vertices[j] + piece.vertices[k]) / 3.0;
    sum += area * whole.WindingNumber(middle - kBehind * std::sqrt(area) * normal.normalized());
    total += area;
  }
  return total > 0.0 ? sum / total : 0.5;
}

}  // namespace palpate
