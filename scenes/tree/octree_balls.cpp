#include "scenes/tree/octree_balls.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <queue>
#include <utility>

namespace palpate {
namespace {

constexpr int kDeepest = 20;
constexpr double kRounding =
    1e-12;  // of the root's half side: what touches a common face belongs to both cells

struct Cell {
  Vec3 middle = Vec3::Zero();
  double half = 0.0;  ///< of its side [m]
  int depth = 0;
  std::vector<std::uint32_t> triangles;  ///< those that touch it
};

/// Returns whether triangle and cube have a common point, by testing the axes that may separate
/// them: those of the cube, the triangle's normal, and the products of their edges (Akenine-Möller,
/// J. Graphics Tools 6 (2001) 29-33).
bool Touches(const TriangleMesh& mesh, std::uint32_t triangle, const Vec3& middle, double half) {
  Vec3 corner[3];
  for (int k = 0; k < 3; ++k) corner[k] = mesh.vertices[mesh.triangles[triangle][k]] - middle;
  const auto apart = [&](const Vec3& axis) {
    const double a = axis.dot(corner[0]), b = axis.dot(corner[1]), c = axis.dot(corner[2]);
    const double reach = half * axis.cwiseAbs().sum();
    return std::min({a, b, c}) > reach || std::max({a, b, c}) < -reach;
  };
  const Vec3 edge[3] = {corner[1] - corner[0], corner[2] - corner[1], corner[0] - corner[2]};
  for (int i = 0; i < 3; ++i) {
    if (apart(Vec3::Unit(i))) return false;
  }
  if (apart(edge[0].cross(edge[1]))) return false;
  for (int i = 0; i < 3; ++i) {
    for (const Vec3& e : edge) {
      if (apart(Vec3::Unit(i).cross(e))) return false;
    }
  }
  return true;
}

class Octree {
 public:
  Octree(const TriangleMesh& mesh, const MeshQuery& query) : mesh_(mesh), query_(query) {
    Vec3 low = mesh.vertices[mesh.triangles[0][0]], high = low;
    for (const auto& triangle : mesh.triangles) {
      for (const std::uint32_t v : triangle) {
        low = low.cwiseMin(mesh.vertices[v]);
        high = high.cwiseMax(mesh.vertices[v]);
      }
    }
    Cell root;
    root.middle = 0.5 * (low + high);
    root.half = 0.5 * (high - low).maxCoeff();
    margin_ = kRounding * (root.half + root.middle.cwiseAbs().maxCoeff());
    root.triangles.resize(mesh.triangles.size());
    std::iota(root.triangles.begin(), root.triangles.end(), 0u);
    Add(std::move(root));
  }

  std::vector<Sphere> Run(std::size_t count) {
    while (!to_split_.empty() && kept_ < count) {
      const std::size_t c = to_split_.top().cell;
      to_split_.pop();
      if (cells_[c].depth >= kDeepest) continue;
      std::vector<Cell> parts = PartsOf(cells_[c]);
      // Without parts, by rounding, if hardly anything touches the cell: it stays.
      if (parts.empty() || kept_ - 1 + parts.size() > count) continue;
      cells_[c] = {};
      --kept_;
      for (Cell& part : parts) Add(std::move(part));
    }
    std::vector<Sphere> balls;
    for (const Cell& cell : cells_) {
      if (cell.half > 0.0) balls.push_back(BallRound(cell));
    }
    return balls;
  }

 private:
  struct Turn {
    int depth;
    double sticks_out;
    std::size_t cell;
    bool operator<(const Turn& other) const {  // the greatest is split first
      if (depth != other.depth) return depth > other.depth;
      if (sticks_out != other.sticks_out) return sticks_out < other.sticks_out;
      return cell > other.cell;
    }
  };

  Sphere BallRound(const Cell& cell) const {
    return {cell.middle, std::sqrt(3.0) * (cell.half + margin_)};
  }

  void Add(Cell cell) {
    ++kept_;
    if (!cell.triangles.empty()) {
      const double apart = query_.Nearest(cell.middle).distance;
      const double sticks_out =
          (query_.Inside(cell.middle) ? -apart : apart) + BallRound(cell).radius;
      to_split_.push({cell.depth, sticks_out, cells_.size()});
    }
    cells_.push_back(std::move(cell));
  }

  std::vector<Cell> PartsOf(const Cell& cell) const {
    std::vector<Cell> parts;
    const double half = 0.5 * cell.half;
    for (int i = 0; i < 8; ++i) {
      Cell part;
      part.half = half;
      part.depth = cell.depth + 1;
      part.middle =
          cell.middle + half * Vec3(i & 1 ? 1.0 : -1.0, i & 2 ? 1.0 : -1.0, i & 4 ? 1.0 : -1.0);
      for (const std::uint32_t t : cell.triangles) {
        if (Touches(mesh_, t, part.middle, half + margin_)) part.triangles.push_back(t);
      }
      if (!part.triangles.empty() || query_.Inside(part.middle)) parts.push_back(std::move(part));
    }
    return parts;
  }

  const TriangleMesh& mesh_;
  const MeshQuery& query_;
  double margin_ = 0.0;
  std::size_t kept_ = 0;
  std::vector<Cell> cells_;  ///< those with `half` 0 were split
  std::priority_queue<Turn> to_split_;
};

}  // namespace

std::vector<Sphere> OctreeBalls(const TriangleMesh& mesh, const MeshQuery& query,
                                std::size_t count) {
  return Octree(mesh, query).Run(count);
}

}  // namespace palpate
