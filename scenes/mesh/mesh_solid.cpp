#include "scenes/mesh/mesh_solid.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include <spdlog/fmt/fmt.h>

#include "scenes/mesh/mesh_edges.h"
#include "scenes/mesh/mesh_pieces.h"
#include "scenes/mesh/mesh_query.h"
#include "scenes/mesh/mesh_report.h"

namespace palpate {
namespace {

/// Of the bounding box's diagonal: as thick as some 700 leaves over the sheet are far apart, so
/// that they can cover it, and thin enough to be felt as one.
constexpr double kSheetThickness = 0.02;
/// Of it: a ball that rests on the rim of a hole sticks out by less than half of the hole's width.
constexpr double kWideOpening = 0.05;
/// More pieces are a soup, whose parts mean nothing alone.
constexpr std::size_t kMostPieces = 1000;

/// Adds the second face of an open piece, and the walls between.
void AddPlate(const MeshPiece& piece, double thickness, TriangleMesh& mesh) {
  std::vector<Vec3> normals(piece.mesh.vertices.size(), Vec3::Zero());
  for (const auto& t : piece.mesh.triangles) {
    const Vec3& a = piece.mesh.vertices[t[0]];
    const Vec3 area = (piece.mesh.vertices[t[1]] - a).cross(piece.mesh.vertices[t[2]] - a);
    for (const std::uint32_t v : t) normals[v] += area;
  }
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  for (std::size_t v = 0; v < normals.size(); ++v) {
    mesh.vertices.push_back(piece.mesh.vertices[v] - thickness * normals[v].normalized());
  }
  for (const auto& [i, j, k] : piece.mesh.triangles) {
    mesh.triangles.push_back({first + i, first + k, first + j});
  }
  for (const OpenEdge& edge : OpenEdges(piece.mesh)) {
    const std::uint32_t from = piece.vertex[edge.from], to = piece.vertex[edge.to];
    mesh.triangles.push_back({to, from, first + edge.from});
    mesh.triangles.push_back({to, first + edge.from, first + edge.to});
  }
}

/// Open edges end to end.
using Loop = std::vector<OpenEdge>;

std::vector<Loop> LoopsOf(const TriangleMesh& mesh) {
  const std::vector<OpenEdge> edges = OpenEdges(mesh);
  std::multimap<std::uint32_t, std::size_t> from;
  for (std::size_t e = 0; e < edges.size(); ++e) from.emplace(edges[e].from, e);
  std::vector<Loop> loops;
  while (!from.empty()) {
    Loop loop;
    for (auto it = from.begin(); it != from.end(); it = from.find(loop.back().to)) {
      loop.push_back(edges[it->second]);
      from.erase(it);
      if (loop.back().to == loop.front().from) break;
    }
    loops.push_back(std::move(loop));
  }
  return loops;
}

double WidthOf(const Loop& loop, const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const OpenEdge& edge : loop) box.extend(mesh.vertices[edge.from]);
  return box.diagonal().norm();
}

/// Adds a cone over each opening of a piece, its tip in the middle of the rim.
/// Returns how wide the widest is.
double AddLids(const MeshPiece& piece, const std::vector<Loop>& loops, TriangleMesh& mesh) {
  double widest = 0.0;
  for (const Loop& loop : loops) {
    widest = std::max(widest, WidthOf(loop, piece.mesh));
    const auto tip = static_cast<std::uint32_t>(mesh.vertices.size());
    Vec3 middle = Vec3::Zero();
    double length = 0.0;
    for (const OpenEdge& edge : loop) {
      const Vec3& a = piece.mesh.vertices[edge.from];
      const Vec3& b = piece.mesh.vertices[edge.to];
      middle += 0.5 * (b - a).norm() * (a + b);
      length += (b - a).norm();
      mesh.triangles.push_back({piece.vertex[edge.to], piece.vertex[edge.from], tip});
    }
    mesh.vertices.push_back(length > 0.0 ? Vec3(middle / length)
                                         : piece.mesh.vertices[loop.front().from]);
  }
  return widest;
}

}  // namespace

MeshSolid SolidOf(const TriangleMesh& mesh) {
  MeshSolid solid{mesh, 0.0, 0.0};
  const MeshReport report = InspectMesh(mesh);
  if (report.closed()) return solid;
  const double diagonal = (report.box_max - report.box_min).norm();
  const MeshQuery all(mesh);
  const std::vector<MeshPiece> pieces = PiecesOf(mesh);
  if (pieces.size() > kMostPieces) return solid;
  for (const MeshPiece& piece : pieces) {
    // A scrap of which most edges are open is a part of a soup, unless it stands alone.
    const bool scrap = piece.report.boundary_edges > piece.report.triangles && pieces.size() > 1;
    if (piece.report.closed() || !(piece.report.area > 0.0)) continue;
    const double enclosure = Enclosure(piece.mesh, all);
    if (enclosure <= kShell) {
      if (enclosure < kInsideOutShell) continue;  // of a cavity, say
      solid.thickness = kSheetThickness * diagonal;
      AddPlate(piece, solid.thickness, solid.mesh);
      continue;
    }
    const std::vector<Loop> loops = LoopsOf(piece.mesh);
    const bool wide = std::ranges::any_of(loops, [&](const Loop& loop) {
      return WidthOf(loop, piece.mesh) > kWideOpening * diagonal;
    });
    if (!wide || scrap) continue;
    solid.opening = std::max(solid.opening, AddLids(piece, loops, solid.mesh));
  }
  return solid;
}

std::string SolidRemark(const MeshSolid& solid, double scale, const std::string& unit) {
  std::string remark;
  if (solid.opening > 0.0) {
    remark = fmt::format(
        "its spheres fill it as if a flat lid closed each opening, the widest {:.3g} {} wide; "
        "close it in a mesh editor, or give \"thickness_mm\" in the scene file where it should be "
        "a thin shell",
        scale * solid.opening, unit);
  }
  if (solid.thickness > 0.0) {
    remark += fmt::format(
        "{}it is a sheet, which encloses nothing: its spheres fill a plate behind its faces, "
        "{:.3g} {} thick; give \"thickness_mm\" in the scene file for another",
        remark.empty() ? "" : "; a part of ", scale * solid.thickness, unit);
  }
  return remark;
}

bool Thicken(double thickness, TriangleMesh& mesh) {
  std::set<std::array<std::uint32_t, 3>> seen;
  for (auto& triangle : mesh.triangles) {
    auto corners = triangle;
    std::ranges::sort(corners);
    // Without area, it keeps the numbers of those behind it, which named parts go by.
    if (!seen.insert(corners).second) triangle = {triangle[0], triangle[0], triangle[0]};
  }
  bool any = false;
  for (const MeshPiece& piece : PiecesOf(mesh)) {
    if (piece.report.closed()) continue;
    AddPlate(piece, thickness, mesh);
    any = true;
  }
  return any;
}

}  // namespace palpate
