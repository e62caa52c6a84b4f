#include "scenes/mesh_orient.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numeric>
#include <utility>
#include <vector>

#include "scenes/mesh_query.h"
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

/// A connected piece of a mesh, with numbers of its own for its vertices.
struct Piece {
  TriangleMesh mesh;
  std::vector<std::uint32_t> triangle;  ///< of the whole mesh, of each
  MeshReport report;
};

std::vector<Piece> PiecesOf(const TriangleMesh& mesh) {
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
  std::vector<std::uint32_t> piece_of(mesh.vertices.size(), kNone), renamed(piece_of);
  std::vector<Piece> pieces;
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    std::uint32_t& number = piece_of[root(mesh.triangles[t][0])];
    if (number == kNone) {
      number = static_cast<std::uint32_t>(pieces.size());
      pieces.emplace_back();
    }
    Piece& piece = pieces[number];
    auto corners = mesh.triangles[t];
    for (std::uint32_t& v : corners) {
      if (renamed[v] == kNone) {
        renamed[v] = static_cast<std::uint32_t>(piece.mesh.vertices.size());
        piece.mesh.vertices.push_back(mesh.vertices[v]);
      }
      v = renamed[v];
    }
    piece.mesh.triangles.push_back(corners);
    piece.triangle.push_back(t);
  }
  for (Piece& piece : pieces) piece.report = InspectMesh(piece.mesh);
  return pieces;
}

/// How many of the other pieces wind round this one.
std::size_t Depth(const Piece& piece, const std::vector<Piece>& pieces,
                  std::vector<std::unique_ptr<MeshQuery>>& queries) {
  std::size_t depth = 0;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const Piece& other = pieces[i];
    const bool within = &other != &piece && other.report.solid() &&
                        (other.report.box_min.array() <= piece.report.box_min.array()).all() &&
                        (other.report.box_max.array() >= piece.report.box_max.array()).all();
    if (!within) continue;
    if (!queries[i]) queries[i] = std::make_unique<MeshQuery>(other.mesh);
    depth += std::abs(queries[i]->WindingNumber(piece.mesh.vertices.front())) > 0.5;
  }
  return depth;
}

/// Closed pieces that wind the wrong way, by their numbers of triangles.
std::vector<std::uint32_t> TrianglesInsideOut(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> wrong;
  const std::vector<Piece> pieces = PiecesOf(mesh);
  if (pieces.size() < 2) return wrong;
  std::vector<std::unique_ptr<MeshQuery>> queries(pieces.size());
  for (const Piece& piece : pieces) {
    if (!piece.report.inside_out() || Depth(piece, pieces, queries) % 2 == 1) continue;
    wrong.insert(wrong.end(), piece.triangle.begin(), piece.triangle.end());
  }
  return wrong;
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
  for (std::uint32_t t : TrianglesInsideOut(mesh)) {
    turn(t);
    turned[t] = !turned[t];
  }
  return std::count(turned.begin(), turned.end(), true);
}

}  // namespace palpate
