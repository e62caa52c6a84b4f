#include "scenes/mesh/mesh_pieces.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "scenes/mesh/disjoint_sets.h"
#include "scenes/mesh/mesh_edges.h"
#include "scenes/mesh/triangle.h"

namespace palpate {
namespace {

constexpr std::uint32_t kNoPiece = 0xffffffffu;

/// Returns whether numbers, which count from 0, name at most one thing.
bool IsOne(const std::vector<std::uint32_t>& numbers) {
  return std::ranges::all_of(numbers, [](std::uint32_t number) { return number == 0; });
}

std::vector<std::uint32_t> PatchesBy(const EdgeSides& edges, std::size_t triangles) {
  DisjointSets patches(triangles);
  edges.ForEachEdge([&](std::span<const Side> sides) {
    if (sides.size() == 2) patches.Join(sides[0].triangle, sides[1].triangle);
  });
  std::vector<std::uint32_t> number(triangles, kNoPiece), of(triangles);
  std::uint32_t count = 0;
  for (std::uint32_t t = 0; t < of.size(); ++t) {
    std::uint32_t& patch = number[patches.Find(t)];
    if (patch == kNoPiece) patch = count++;
    of[t] = patch;
  }
  return of;
}

/// Returns by number which patches have only edges with two of their triangles, or with four.
std::vector<bool> ClosedPatches(const EdgeSides& edges, const std::vector<std::uint32_t>& patch) {
  std::vector<bool> closed(patch.size(), false), open = closed;
  std::vector<std::uint32_t> at_edge;
  edges.ForEachEdge([&](std::span<const Side> sides) {
    at_edge.clear();
    for (const Side& side : sides) at_edge.push_back(patch[side.triangle]);
    for (const std::uint32_t p : at_edge) {
      closed[p] = true;  // except a patch without any edges
      if (std::ranges::count(at_edge, p) % 2 == 1) open[p] = true;
    }
  });
  for (std::size_t p = 0; p < closed.size(); ++p) closed[p] = closed[p] && !open[p];
  return closed;
}

/// Returns for each triangle the number of its piece.
std::vector<std::uint32_t> PieceNumbers(const TriangleMesh& mesh) {
  const EdgeSides edges(mesh);
  const std::vector<std::uint32_t> patch = PatchesBy(edges, mesh.triangles.size());
  if (IsOne(patch)) return patch;
  const std::vector<bool> closed = ClosedPatches(edges, patch);
  DisjointSets vertices(mesh.vertices.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (closed[patch[t]]) continue;
    const auto& [i, j, k] = mesh.triangles[t];
    vertices.Join(i, j);
    vertices.Join(j, k);
  }
  std::vector<std::uint32_t> of_patch(mesh.triangles.size(), kNoPiece);
  std::vector<std::uint32_t> of_vertex(mesh.vertices.size(), kNoPiece);
  std::vector<std::uint32_t> number;
  std::uint32_t pieces = 0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::uint32_t& piece =
        closed[patch[t]] ? of_patch[patch[t]] : of_vertex[vertices.Find(mesh.triangles[t][0])];
    if (piece == kNoPiece) piece = pieces++;
    number.push_back(piece);
  }
  return number;
}

}  // namespace

std::vector<std::uint32_t> PatchesOf(const TriangleMesh& mesh) {
  return PatchesBy(EdgeSides(mesh), mesh.triangles.size());
}

std::vector<MeshPiece> PiecesOf(const TriangleMesh& mesh) {
  return PiecesBy(mesh, PieceNumbers(mesh));
}

std::vector<MeshPiece> SeveralPiecesOf(const TriangleMesh& mesh) {
  const std::vector<std::uint32_t> number = PieceNumbers(mesh);
  return IsOne(number) ? std::vector<MeshPiece>() : PiecesBy(mesh, number);
}

std::vector<MeshPiece> PiecesBy(const TriangleMesh& mesh,
                                const std::vector<std::uint32_t>& number) {
  std::vector<MeshPiece> pieces;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (number[t] >= pieces.size()) pieces.resize(number[t] + 1);
    pieces[number[t]].triangle.push_back(t);
  }
  // Holds the vertex numbers of one piece at a time.
  std::vector<std::uint32_t> piece_of(mesh.vertices.size(), kNoPiece);
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
    const Triangle triangle = TriangleOf(piece, t);
    const double area = triangle.Area();
    if (!(area > 0.0)) continue;
    const Vec3 behind = kBehind * std::sqrt(area) * triangle.Across().normalized();
    sum += area * whole.WindingNumber(triangle.Middle() - behind);
    total += area;
  }
  return total > 0.0 ? sum / total : 0.5;
}

}  // namespace palpate
