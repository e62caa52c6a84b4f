#include "scenes/mesh/mesh_orient.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "scenes/mesh/mesh_edges.h"
#include "scenes/mesh/mesh_pieces.h"
#include "scenes/mesh/mesh_query.h"
#include "scenes/mesh/mesh_report.h"
#include "scenes/mesh/triangle.h"

namespace palpate {
namespace {

constexpr std::uint32_t kNoNeighbour = 0xffffffffu;

struct Neighbour {
  std::uint32_t triangle = kNoNeighbour;
  bool agrees = true;  ///< whether it runs along the shared edge the other way, as it should
};

/// Each triangle's neighbours across edges of exactly two triangles; kNoNeighbour after the last.
using Neighbours = std::array<Neighbour, 3>;

std::vector<Neighbours> FindNeighbours(const TriangleMesh& mesh) {
  std::vector<Neighbours> neighbours(mesh.triangles.size());
  const auto add = [&](const Side& of, const Side& other) {
    *std::ranges::find(neighbours[of.triangle], kNoNeighbour, &Neighbour::triangle) = {
        other.triangle, of.forward != other.forward};
  };
  EdgeSides(mesh).ForEachEdge([&](std::span<const Side> sides) {
    if (sides.size() != 2) return;
    add(sides[0], sides[1]);
    add(sides[1], sides[0]);
  });
  return neighbours;
}

/// Number of a piece's vertices that are tested for whether another piece winds round it.
constexpr std::size_t kMostVerticesAsked = 64;

/// Returns whether a piece lies entirely in another, and does not intersect its surface.
bool LiesIn(const MeshPiece& piece, const MeshQuery& other) {
  const auto& vertices = piece.mesh.vertices;
  for (std::size_t v = 0; v < vertices.size(); v += 1 + vertices.size() / kMostVerticesAsked) {
    if (!(std::abs(other.WindingNumber(vertices[v])) > 0.5)) return false;
  }
  return true;
}

/// Returns how many of the other pieces wind round this one.
std::size_t Depth(const MeshPiece& piece, const std::vector<MeshPiece>& pieces,
                  std::vector<std::unique_ptr<MeshQuery>>& queries) {
  std::size_t depth = 0;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const MeshPiece& other = pieces[i];
    const bool within = &other != &piece && other.report.solid() &&
                        (other.report.box_min.array() <= piece.report.box_min.array()).all() &&
                        (other.report.box_max.array() >= piece.report.box_max.array()).all();
    if (!within) continue;
    if (!queries[i]) queries[i] = std::make_unique<MeshQuery>(other.mesh);
    depth += LiesIn(piece, *queries[i]);
  }
  return depth;
}

/// Returns the triangles of closed pieces that are wound the wrong way.
std::vector<std::uint32_t> TrianglesInsideOut(const TriangleMesh& mesh) {
  std::vector<std::uint32_t> wrong;
  const std::vector<MeshPiece> pieces = SeveralPiecesOf(mesh);
  std::vector<std::unique_ptr<MeshQuery>> queries(pieces.size());
  for (const MeshPiece& piece : pieces) {
    if (!piece.report.inside_out() || Depth(piece, pieces, queries) % 2 == 1) continue;
    wrong.insert(wrong.end(), piece.triangle.begin(), piece.triangle.end());
  }
  return wrong;
}

/// The most patches whose surroundings are tested: each takes a few winding numbers.
constexpr std::size_t kMostPatches = 200'000;
constexpr std::size_t kMostOpenPieces = 1000;
constexpr int kPasses = 3;  // a patch is judged by neighbours that may have to turn, too

/// Returns the winding number of all but a patch in front of it, minus that behind it, on average:
/// near -1 if the others enclose the space behind the patch, near 1 if it is turned the wrong way,
/// and near 0 if they do not decide.
double WindingAcross(const MeshPiece& patch, const MeshQuery& all) {
  constexpr std::size_t kMostSamples = 16;
  const MeshQuery own(patch.mesh);
  double sum = 0.0;
  std::size_t samples = 0;
  const std::size_t count = patch.mesh.triangles.size();
  for (std::size_t t = 0; t < count; t += 1 + count / kMostSamples) {
    const Triangle triangle = TriangleOf(patch.mesh, t);
    // At half of a triangle's size, a hole of its size hides little of what surrounds it.
    const double away = 0.5 * std::sqrt(triangle.Area());
    const Vec3 step = away * own.FaceNormal(static_cast<std::uint32_t>(t));
    const Vec3 middle = triangle.Middle();
    const auto rest = [&](const Vec3& p) { return all.WindingNumber(p) - own.WindingNumber(p); };
    sum += rest(middle + step) - rest(middle - step);
    ++samples;
  }
  return sum / static_cast<double>(samples);
}

/// Turns patches that share no edge with the others, but close a hole in them.
template <class Turn>
void TurnPatches(TriangleMesh& mesh, const std::vector<std::uint32_t>& patch_of, Turn turn) {
  for (int pass = 0; pass < kPasses; ++pass) {
    const MeshQuery all(mesh);
    std::vector<std::uint32_t> wrong;
    for (const MeshPiece& patch : PiecesBy(mesh, patch_of)) {
      if (patch.report.closed() || WindingAcross(patch, all) < 0.5) continue;
      wrong.insert(wrong.end(), patch.triangle.begin(), patch.triangle.end());
    }
    if (wrong.empty()) return;
    for (const std::uint32_t t : wrong) turn(t);
  }
}

/// Returns how much nearer to 1, the value behind a solid's surface, the winding number behind an
/// open piece would be if the piece were turned.  If that number is E, and E0 for the piece alone,
/// it would become 1 - E0 + (E - E0): the piece's sides are swapped, and the rest stays.
double GainOfTurning(const MeshPiece& piece, const MeshQuery& all) {
  const double now = Enclosure(piece.mesh, all);
  const double turned = 1.0 + now - 2.0 * Enclosure(piece.mesh, MeshQuery(piece.mesh));
  return std::abs(now - 1.0) - std::abs(turned - 1.0);
}

/// Turns open pieces that would enclose more afterwards, the largest first.
template <class Turn>
void TurnOpenShells(TriangleMesh& mesh, Turn turn) {
  std::vector<MeshPiece> pieces = PiecesOf(mesh);
  std::erase_if(pieces, [](const MeshPiece& piece) { return piece.report.closed(); });
  if (pieces.size() > kMostOpenPieces) return;
  std::ranges::stable_sort(pieces, std::greater(),
                           [](const MeshPiece& piece) { return piece.report.area; });
  std::unique_ptr<MeshQuery> all;
  for (const MeshPiece& piece : pieces) {
    if (!all) all = std::make_unique<MeshQuery>(mesh);
    if (GainOfTurning(piece, *all) < kShell - kInsideOutShell) continue;
    for (const std::uint32_t t : piece.triangle) turn(t);
    all.reset();
  }
}

}  // namespace

std::size_t OrientTriangles(TriangleMesh& mesh) {
  const auto neighbours = FindNeighbours(mesh);
  std::vector<bool> turned(mesh.triangles.size(), false);
  std::vector<bool> seen(mesh.triangles.size(), false);
  std::vector<std::uint32_t> patch_of(mesh.triangles.size());
  std::uint32_t patches = 0;
  for (std::uint32_t start = 0; start < mesh.triangles.size(); ++start) {
    if (seen[start]) continue;
    seen[start] = true;
    std::vector<std::uint32_t> patch{start};
    double area[2] = {0.0, 0.0};  // as it was, and turned
    for (std::size_t next = 0; next < patch.size(); ++next) {
      const std::uint32_t t = patch[next];
      patch_of[t] = patches;
      area[turned[t]] += TriangleOf(mesh, t).Across().norm();
      for (const Neighbour& n : neighbours[t]) {
        if (n.triangle == kNoNeighbour) break;
        if (seen[n.triangle]) continue;
        seen[n.triangle] = true;
        turned[n.triangle] = turned[t] == n.agrees;
        patch.push_back(n.triangle);
      }
    }
    ++patches;
    if (area[1] <= area[0]) continue;
    for (std::uint32_t t : patch) turned[t] = !turned[t];
  }
  for (std::uint32_t t = 0; t < turned.size(); ++t) {
    if (turned[t]) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
  }
  const auto turn = [&](std::uint32_t t) {
    std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
    turned[t] = !turned[t];
  };
  const MeshReport report = InspectMesh(mesh);
  if (report.inside_out()) {
    for (std::uint32_t t = 0; t < turned.size(); ++t) turn(t);
  }
  if (patches > 1) {
    for (std::uint32_t t : TrianglesInsideOut(mesh)) turn(t);
  }
  if (!report.closed() && report.area > 0.0) {
    if (patches > 1 && patches <= kMostPatches) TurnPatches(mesh, patch_of, turn);
    TurnOpenShells(mesh, turn);
  }
  return std::count(turned.begin(), turned.end(), true);
}

}  // namespace palpate
