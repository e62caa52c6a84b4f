#include "scenes/mesh/mesh_pieces.h"

#include <cmath>
#include <numeric>

namespace palpate {

std::vector<MeshPiece> PiecesOf(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](std::uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const auto& [i, j, k] : mesh.triangles) {
    parent[root(i)] = root(j);
    parent[root(j)] = root(k);
  }
  constexpr std::uint32_t kNone = 0xffffffffu;
  std::vector<std::uint32_t> piece_of(mesh.vertices.size(), kNone), number;
  std::uint32_t pieces = 0;
  for (const auto& triangle : mesh.triangles) {
    std::uint32_t& piece = piece_of[root(triangle[0])];
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
  std::vector<std::uint32_t> piece_of(mesh.vertices.size(), 0xffffffffu);
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
