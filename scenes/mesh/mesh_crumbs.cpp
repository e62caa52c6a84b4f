#include "scenes/mesh/mesh_crumbs.h"

#include <algorithm>
#include <cstdint>

#include "scenes/mesh/mesh_edges.h"
#include "scenes/mesh/mesh_pieces.h"
#include "scenes/mesh/mesh_query.h"

namespace palpate {
namespace {

/// Size of a small piece, as a share of the mesh's diagonal: 2 mm of a jaw's 70 mm.
constexpr double kSmall = 0.03;
/// Size of a closed piece that is removed, as a share of the same: 40 um of 40 mm, which
/// no hand feels.
constexpr double kDust = 1e-3;
/// Limit of all crumbs together, as a share of the surface: more was probably intended.
constexpr double kHardlyAny = 0.01;
/// Least distance of a crumb, in its own diagonals: an unjoined patch of the surface lies nearer.
constexpr double kApart = 0.25;

double DiagonalOf(const MeshReport& report) {
  return (report.box_max - report.box_min).norm();
}

/// Returns whether a piece lies apart from a mesh, judged by its vertices.
bool FloatsApart(const MeshPiece& piece, const MeshQuery& rest) {
  const double least = kApart * DiagonalOf(piece.report);
  return std::ranges::none_of(piece.mesh.vertices, [&](const Vec3& v) {
    return rest.Nearest(v, least).triangle != MeshQuery::kNone;
  });
}

void LeaveOutUnusedVertices(TriangleMesh& mesh) {
  std::vector<bool> used(mesh.vertices.size(), false);
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t v : triangle) used[v] = true;
  }
  std::vector<std::uint32_t> renamed(mesh.vertices.size(), 0);
  std::uint32_t count = 0;
  for (std::size_t v = 0; v < used.size(); ++v) {
    if (!used[v]) continue;
    mesh.vertices[count] = mesh.vertices[v];
    renamed[v] = count++;
  }
  mesh.vertices.resize(count);
  for (auto& triangle : mesh.triangles) {
    for (std::uint32_t& v : triangle) v = renamed[v];
  }
}

Corners Sorted(Corners corners) {
  std::ranges::sort(corners);
  return corners;
}

}  // namespace

void KeepTriangles(const std::vector<bool>& kept, TriangleMesh& mesh,
                   std::vector<MeshGroup>* groups) {
  std::vector<std::uint32_t> before(kept.size() + 1, 0);  // number of triangles kept before each
  for (std::size_t t = 0; t < kept.size(); ++t) before[t + 1] = before[t] + kept[t];
  for (std::size_t t = 0; t < kept.size(); ++t) {
    if (kept[t]) mesh.triangles[before[t]] = mesh.triangles[t];
  }
  mesh.triangles.resize(before.back());
  if (groups == nullptr) return;
  for (MeshGroup& group : *groups) {
    group.begin = before[group.begin];
    group.end = before[group.end];
  }
}

std::size_t LeaveOutRepeatedTriangles(TriangleMesh& mesh, std::vector<MeshGroup>* groups) {
  std::vector<bool> first = FindRepeated(mesh.triangles, mesh.vertices.size());
  first.flip();
  if (std::ranges::find(first, false) == first.end()) return 0;
  TriangleMesh once = mesh;
  KeepTriangles(first, once);
  // Corners of the triangles that would be left as a sheet.
  std::vector<Corners> of_sheets;
  for (const MeshPiece& piece : PiecesOf(once)) {
    if (piece.report.closed()) continue;
    const double enclosure = Enclosure(piece.mesh, MeshQuery(piece.mesh));
    if (enclosure > kShell || enclosure < kInsideOutShell) continue;
    for (const std::uint32_t t : piece.triangle) of_sheets.push_back(Sorted(once.triangles[t]));
  }
  std::ranges::sort(of_sheets);
  std::vector<bool> kept = first;
  for (std::size_t t = 0; t < kept.size(); ++t) {
    kept[t] = kept[t] || std::ranges::binary_search(of_sheets, Sorted(mesh.triangles[t]));
  }
  const auto left_out = static_cast<std::size_t>(std::ranges::count(kept, false));
  if (left_out > 0) KeepTriangles(kept, mesh, groups);
  return left_out;
}

Crumbs LeaveOutCrumbs(TriangleMesh& mesh, std::vector<MeshGroup>* groups) {
  const std::vector<MeshPiece> pieces = SeveralPiecesOf(mesh);
  if (pieces.empty()) return {};
  const auto main = std::ranges::max_element(
      pieces, {}, [](const MeshPiece& piece) { return piece.report.area; });
  // Not the whole mesh's box, which distant crumbs would enlarge.
  const double diagonal = DiagonalOf(main->report);
  double area = 0.0, area_of_crumbs = 0.0;
  std::vector<const MeshPiece*> small;
  std::vector<bool> large(mesh.triangles.size(), true);
  for (const MeshPiece& piece : pieces) {
    area += piece.report.area;
    if (DiagonalOf(piece.report) > kSmall * diagonal) continue;
    small.push_back(&piece);
    for (const std::uint32_t t : piece.triangle) large[t] = false;
  }
  if (small.empty()) return {};
  TriangleMesh rest = mesh;
  KeepTriangles(large, rest);
  const MeshQuery query(rest);
  Crumbs crumbs;
  std::vector<bool> kept(mesh.triangles.size(), true);
  for (const MeshPiece* piece : small) {
    if (!FloatsApart(*piece, query)) continue;
    crumbs.largest = std::max(crumbs.largest, DiagonalOf(piece->report));
    area_of_crumbs += piece->report.area;
    if (piece->report.closed() && DiagonalOf(piece->report) > kDust * diagonal) {
      ++crumbs.kept;
      continue;
    }
    ++crumbs.left_out;
    for (const std::uint32_t t : piece->triangle) kept[t] = false;
  }
  if (area_of_crumbs > kHardlyAny * area) return {};
  if (crumbs.left_out > 0) {
    KeepTriangles(kept, mesh, groups);
    LeaveOutUnusedVertices(mesh);
  }
  return crumbs;
}

}  // namespace palpate
