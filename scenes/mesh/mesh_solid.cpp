#include "scenes/mesh/mesh_solid.h"

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "scenes/mesh/figure.h"
#include "scenes/mesh/hidden_surface.h"
#include "scenes/mesh/mesh_edges.h"
#include "scenes/mesh/mesh_pieces.h"
#include "scenes/mesh/mesh_query.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/mesh/triangle.h"

namespace palpate {
namespace {

/// Thickness of a plate, as a share of the bounding box's diagonal.  It equals the spacing of some
/// 700 leaves over the sheet, so they can cover it, and is thin enough to feel like a sheet.
constexpr double kSheetThickness = 0.02;
/// Width of a wide opening, as a share of the same: a ball on the rim of a hole protrudes by less
/// than half of the hole's width.
constexpr double kWideOpening = 0.05;
/// More pieces are a soup, whose parts have no meaning on their own.
constexpr std::size_t kMostPieces = 1000;

/// Adds the second face of an open piece, and the walls between both.
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

/// Open edges of a mesh, each by its ends, the lower number first.
using EdgeSet = std::set<std::pair<std::uint32_t, std::uint32_t>>;

/// A chain of open edges that passes no vertex twice.
using Loop = std::vector<OpenEdge>;

/// @param open  the open edges of the whole mesh; other edges of the piece do not count.
std::vector<Loop> LoopsOf(const MeshPiece& piece, const EdgeSet& open) {
  std::vector<OpenEdge> edges = OpenEdges(piece.mesh);
  std::erase_if(edges, [&](const OpenEdge& edge) {
    return !open.contains(std::minmax(piece.vertex[edge.from], piece.vertex[edge.to]));
  });
  std::multimap<std::uint32_t, std::size_t> from;
  for (std::size_t e = 0; e < edges.size(); ++e) from.emplace(edges[e].from, e);
  std::vector<Loop> loops;
  while (!from.empty()) {
    Loop way;
    std::map<std::uint32_t, std::size_t> passed;  // for each vertex, the length of the way to it
    for (auto it = from.begin(); it != from.end(); it = from.find(way.back().to)) {
      passed.emplace(edges[it->second].from, way.size());
      way.push_back(edges[it->second]);
      from.erase(it);
      const auto again = passed.find(way.back().to);
      if (again == passed.end()) continue;
      // Two openings that meet at a vertex, as in a chain of T-junctions, are separate.
      const auto begin = way.begin() + static_cast<std::ptrdiff_t>(again->second);
      loops.emplace_back(begin, way.end());
      for (const OpenEdge& edge : loops.back()) passed.erase(edge.from);
      way.erase(begin, way.end());
      if (way.empty()) break;
    }
    if (!way.empty()) loops.push_back(std::move(way));
  }
  return loops;
}

double WidthOf(const Loop& loop, const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const OpenEdge& edge : loop) box.extend(mesh.vertices[edge.from]);
  return box.diagonal().norm();
}

/// A cone over an opening, with its tip in the middle of the rim.
struct Lid {
  Vec3 tip = Vec3::Zero();
  const Loop* loop = nullptr;
};

Lid LidOver(const Loop& loop, const TriangleMesh& mesh) {
  Vec3 middle = Vec3::Zero();
  double length = 0.0;
  for (const OpenEdge& edge : loop) {
    const Vec3& a = mesh.vertices[edge.from];
    const Vec3& b = mesh.vertices[edge.to];
    middle += 0.5 * (b - a).norm() * (a + b);
    length += (b - a).norm();
  }
  return {length > 0.0 ? Vec3(middle / length) : mesh.vertices[loop.front().from], &loop};
}

/// Returns whether the solid continues beyond an opening, as at a crack between two scans that were
/// put together; a lid would be a wall inside.  In a real opening the winding number is 1/2.
bool GoesOnBeyond(const Lid& lid, const TriangleMesh& mesh, const MeshQuery& all) {
  constexpr std::size_t kMostAsked = 16;
  constexpr double kGoesOn = 0.75;
  double sum = 0.0;
  std::size_t asked = 0;
  for (std::size_t i = 0; i < lid.loop->size(); i += 1 + lid.loop->size() / kMostAsked) {
    const OpenEdge& edge = (*lid.loop)[i];
    sum += all.WindingNumber((mesh.vertices[edge.from] + mesh.vertices[edge.to] + lid.tip) / 3.0);
    ++asked;
  }
  return sum > kGoesOn * static_cast<double>(asked);
}

/// Adds lids over openings of a piece.
void AddLids(const MeshPiece& piece, const std::vector<Lid>& lids, TriangleMesh& mesh) {
  for (const Lid& lid : lids) {
    const auto tip = static_cast<std::uint32_t>(mesh.vertices.size());
    for (const OpenEdge& edge : *lid.loop) {
      mesh.triangles.push_back({piece.vertex[edge.to], piece.vertex[edge.from], tip});
    }
    mesh.vertices.push_back(lid.tip);
  }
}

/// Number of triangles of a patch that are tested first: if none lies inside, the patch is outside.
constexpr std::size_t kProbes = 128;
/// Limit for all patches together.
constexpr std::size_t kMostProbes = 20'000;

/// Removes surface that has solid on both sides, which nothing touches and at which a ball inside
/// would have to end: the inner of two shells, one of which was to thicken the other; the parts of
/// intersecting shells inside each other; a wall inside.  A triangle that is partly removed becomes
/// one remaining part, and new triangles are added for the others; one that is wholly removed
/// becomes a point.  So all other triangles keep their numbers.
class WallTaker {
 public:
  /// @param mesh  must outlive this.
  explicit WallTaker(const TriangleMesh& mesh) : from_(mesh), surface_(mesh) {}

  /// @param mesh     a copy of the constructor's.
  /// @param part_of  for each new triangle, the one that it is a part of.
  void Run(TriangleMesh& mesh, std::vector<std::uint32_t>& part_of) {
    if (!surface_.possible()) return;
    const std::vector<std::vector<std::uint32_t>> patches = Patches();
    // What lies behind a single open surface is uncertain, and it is no wall.
    if (patches.size() > kMostProbes || (patches.size() == 1 && !surface_.closed())) return;
    for (const std::vector<std::uint32_t>& patch : patches) {
      if (!MayHide(patch, patches.size())) continue;
      for (const std::uint32_t t : patch) {
        Take(t, mesh);
        part_of.resize(mesh.triangles.size() - from_.triangles.size(), t);
      }
    }
    std::vector<bool> gone(from_.triangles.size(), false);
    for (const std::uint32_t t : gone_) gone[t] = true;
    const auto left = std::ranges::find(gone, false);
    if (left == gone.end()) return;  // such a tangle cannot be judged
    const std::uint32_t point = mesh.triangles[static_cast<std::size_t>(left - gone.begin())][0];
    for (const std::uint32_t t : gone_) mesh.triangles[t] = {point, point, point};
  }

 private:
  /// Smallest part of a triangle that is divided, as a share of the box's diagonal: a ball that
  /// ends at a smaller part ends near the remaining surface.
  static constexpr double kSmall = 0.01;
  /// Larger parts are always divided, because more may lie inside than at four places.
  static constexpr double kLarge = 0.1;

  std::vector<std::vector<std::uint32_t>> Patches() {
    const std::vector<std::uint32_t> patch_of = PatchesOf(from_);
    std::vector<std::vector<std::uint32_t>> patches;
    for (std::uint32_t t = 0; t < patch_of.size(); ++t) {
      if (patch_of[t] >= patches.size()) patches.emplace_back();
      patches[patch_of[t]].push_back(t);
    }
    const Eigen::AlignedBox3d box = BoxOf(from_);
    diagonal_ = box.isEmpty() ? 0.0 : box.diagonal().norm();
    return patches;
  }

  std::array<Vec3, 3> CornersOf(const std::array<std::uint32_t, 3>& part,
                                const TriangleMesh& mesh) const {
    return {mesh.vertices[part[0]], mesh.vertices[part[1]], mesh.vertices[part[2]]};
  }

  bool MayHide(const std::vector<std::uint32_t>& patch, std::size_t patches) const {
    const std::size_t probes = std::clamp<std::size_t>(kMostProbes / patches, 1, kProbes);
    if (patch.size() <= probes) return true;
    for (std::size_t i = 0; i < probes; ++i) {
      const std::uint32_t t = patch[i * patch.size() / probes];
      if (surface_.Places(t, CornersOf(from_.triangles[t], from_)) > 0) return true;
    }
    return false;
  }

  void Take(std::uint32_t t, TriangleMesh& mesh) {
    const std::size_t vertices = mesh.vertices.size();
    kept_.clear();
    if (Divide(t, from_.triangles[t], mesh)) {
      mesh.vertices.resize(vertices);  // none of it lies inside: leave it
    } else if (kept_.empty()) {
      gone_.push_back(t);
    } else {
      mesh.triangles[t] = kept_.front();
      mesh.triangles.insert(mesh.triangles.end(), kept_.begin() + 1, kept_.end());
    }
  }

  /// Keeps the parts of a part of triangle t that do not lie inside.  Returns whether that is
  /// all of it.
  bool Divide(std::uint32_t t, const std::array<std::uint32_t, 3>& part, TriangleMesh& mesh) {
    const std::array<Vec3, 3> corner = CornersOf(part, mesh);
    const int places = surface_.Places(t, corner);
    if (places == HiddenSurface::kAllPlaces) return false;
    double longest = 0.0;
    for (std::size_t c = 0; c < 3; ++c) {
      longest = std::max(longest, (corner[(c + 1) % 3] - corner[c]).norm());
    }
    if (!(longest > (places > 0 ? kSmall : kLarge) * diagonal_)) {
      kept_.push_back(part);
      return true;
    }
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (std::size_t c = 0; c < 3; ++c) {
      mesh.vertices.push_back(0.5 * (corner[c] + corner[(c + 1) % 3]));
    }
    bool all = true;
    for (std::uint32_t c = 0; c < 3; ++c) {
      all = Divide(t, {part[c], first + c, first + (c + 2) % 3}, mesh) && all;
    }
    return Divide(t, {first, first + 1, first + 2}, mesh) && all;
  }

  const TriangleMesh& from_;
  HiddenSurface surface_;
  double diagonal_ = 0.0;
  std::vector<std::uint32_t> gone_;
  std::vector<std::array<std::uint32_t, 3>> kept_;
};

}  // namespace

MeshSolid SolidOf(const TriangleMesh& mesh) {
  MeshSolid solid{mesh, {}, 0.0, 0.0};
  WallTaker(mesh).Run(solid.mesh, solid.part_of);
  const MeshReport report = InspectMesh(mesh);
  if (report.closed()) return solid;
  const double diagonal = (report.box_max - report.box_min).norm();
  const TriangleMesh outside = solid.mesh;
  const MeshQuery all(outside);
  const std::vector<MeshPiece> pieces = PiecesOf(outside);
  if (pieces.size() > kMostPieces) return solid;
  // Where an inner wall was removed, there is no opening.
  EdgeSet open;
  for (const OpenEdge& edge : OpenEdges(mesh)) open.insert(std::minmax(edge.from, edge.to));
  for (const MeshPiece& piece : pieces) {
    // A scrap with mostly open edges is part of a soup, unless it is the only piece.
    const bool scrap = piece.report.boundary_edges > piece.report.triangles && pieces.size() > 1;
    if (piece.report.closed() || !(piece.report.area > 0.0)) continue;
    const double enclosure = Enclosure(piece.mesh, all);
    if (enclosure <= kShell) {
      if (enclosure < kInsideOutShell) continue;  // a cavity, for example
      solid.thickness = kSheetThickness * diagonal;
      AddPlate(piece, solid.thickness, solid.mesh);
      continue;
    }
    const std::vector<Loop> loops = LoopsOf(piece, open);
    std::vector<Lid> lids;
    double widest = 0.0;
    for (const Loop& loop : loops) {
      const Lid lid = LidOver(loop, piece.mesh);
      if (GoesOnBeyond(lid, piece.mesh, all)) continue;
      lids.push_back(lid);
      widest = std::max(widest, WidthOf(loop, piece.mesh));
    }
    if (!(widest > kWideOpening * diagonal) || scrap) continue;
    solid.opening = std::max(solid.opening, widest);
    AddLids(piece, lids, solid.mesh);
  }
  return solid;
}

std::string SolidRemark(const MeshSolid& solid, double scale, const std::string& unit) {
  std::string remark;
  if (solid.opening > 0.0) {
    remark = "its spheres fill it as if a flat lid closed each opening, the widest " +
             Figure(scale * solid.opening, 3) + " " + unit +
             " wide; close it in a mesh editor, or give \"thickness_mm\" in the scene file where "
             "it should be a thin shell";
  }
  if (solid.thickness > 0.0) {
    remark += std::string(remark.empty() ? "" : "; a part of ") +
              "it is a sheet, which encloses nothing: its spheres fill a plate behind its faces, " +
              Figure(scale * solid.thickness, 3) + " " + unit +
              " thick; give \"thickness_mm\" in the scene file for another";
  }
  return remark;
}

bool Thicken(double thickness, TriangleMesh& mesh) {
  std::set<std::array<std::uint32_t, 3>> seen;
  for (auto& triangle : mesh.triangles) {
    auto corners = triangle;
    std::ranges::sort(corners);
    // Without area, it keeps the numbers of later triangles, which named parts refer to.
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
