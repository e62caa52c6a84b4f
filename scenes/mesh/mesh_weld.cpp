#include "scenes/mesh/mesh_weld.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include "scenes/mesh/mesh_edges.h"

namespace palpate {
namespace {

constexpr double kOfDiagonal = 1e-5;
constexpr double kOfMedianEdge = 0.05;
/// Least tolerance, as a share of the largest coordinate: less is rounding, and cells of that size
/// could not be counted.
constexpr double kRounding = 1e-15;

/// Returns which vertices end an open edge; empty if there are no open edges.
std::vector<bool> EndsOfOpenEdges(const TriangleMesh& mesh, std::size_t& open) {
  const std::vector<OpenEdge> edges = OpenEdges(mesh);
  open = edges.size();
  if (edges.empty()) return {};
  std::vector<bool> ends(mesh.vertices.size(), false);
  for (const OpenEdge& edge : edges) ends[edge.from] = ends[edge.to] = true;
  return ends;
}

/// Returns the tolerance [the mesh's unit]; 0 if there is none.
double ToleranceOf(const TriangleMesh& mesh) {
  Eigen::AlignedBox3d box;
  std::vector<double> lengths;
  lengths.reserve(3 * mesh.triangles.size());
  for (const auto& t : mesh.triangles) {
    for (int c = 0; c < 3; ++c) {
      const Vec3& a = mesh.vertices[t[static_cast<std::size_t>(c)]];
      const Vec3& b = mesh.vertices[t[static_cast<std::size_t>((c + 1) % 3)]];
      box.extend(a);
      lengths.push_back((b - a).norm());
    }
  }
  const auto middle = lengths.begin() + std::ssize(lengths) / 2;
  std::nth_element(lengths.begin(), middle, lengths.end());
  const double tolerance = std::min(kOfDiagonal * box.diagonal().norm(), kOfMedianEdge * *middle);
  const double farthest =
      std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff());
  return tolerance > kRounding * farthest ? tolerance : 0.0;
}

/// Vertices in a grid of cells of the tolerance's size.
class Cells {
 public:
  Cells(const std::vector<Vec3>& vertices, double size) : vertices_(vertices), size_(size) {}

  /// Returns the first vertex within the tolerance that was added before; else adds and returns v.
  std::uint32_t FirstNear(std::uint32_t v) {
    const Cell at = CellOf(vertices_[v]);
    std::uint32_t first = v;
    for (int n = 0; n < 27; ++n) {
      const auto it = in_.find(Key({at[0] + n % 3 - 1, at[1] + n / 3 % 3 - 1, at[2] + n / 9 - 1}));
      if (it == in_.end()) continue;
      for (const std::uint32_t other : it->second) {
        const double far = (vertices_[other] - vertices_[v]).squaredNorm();
        if (far <= size_ * size_) first = std::min(first, other);
      }
    }
    if (first == v) in_[Key(at)].push_back(v);
    return first;
  }

 private:
  using Cell = std::array<std::int64_t, 3>;
  Cell CellOf(const Vec3& p) const {
    return {static_cast<std::int64_t>(std::floor(p.x() / size_)),
            static_cast<std::int64_t>(std::floor(p.y() / size_)),
            static_cast<std::int64_t>(std::floor(p.z() / size_))};
  }
  /// Different cells may share a key, which only costs time.
  static std::uint64_t Key(const Cell& c) {
    return static_cast<std::uint64_t>(c[0]) * 73856093u ^
           static_cast<std::uint64_t>(c[1]) * 19349663u ^
           static_cast<std::uint64_t>(c[2]) * 83492791u;
  }

  const std::vector<Vec3>& vertices_;
  double size_;
  std::unordered_map<std::uint64_t, std::vector<std::uint32_t>> in_;
};

}  // namespace

Welding WeldOpenEdges(TriangleMesh& mesh) {
  std::size_t open = 0;
  const std::vector<bool> ends = EndsOfOpenEdges(mesh, open);
  if (open == 0) return {};
  Welding welding;
  welding.tolerance = ToleranceOf(mesh);
  if (!(welding.tolerance > 0.0)) return {};
  Cells cells(mesh.vertices, welding.tolerance);
  std::vector<std::uint32_t> renamed(mesh.vertices.size());
  TriangleMesh welded;
  for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) {
    const std::uint32_t first = ends[v] ? cells.FirstNear(v) : v;
    if (first != v) {
      renamed[v] = renamed[first];
      ++welding.vertices;
      continue;
    }
    renamed[v] = static_cast<std::uint32_t>(welded.vertices.size());
    welded.vertices.push_back(mesh.vertices[v]);
  }
  if (welding.vertices == 0) return {};
  welded.triangles = mesh.triangles;
  for (auto& triangle : welded.triangles) {
    for (std::uint32_t& v : triangle) v = renamed[v];
  }
  if (OpenEdges(welded).size() >= open) return {};
  mesh = std::move(welded);
  return welding;
}

}  // namespace palpate
