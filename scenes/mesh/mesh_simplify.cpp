#include "scenes/mesh/mesh_simplify.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <queue>
#include <tuple>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace palpate {
namespace {

constexpr double kLeastCosine = 0.6;     ///< cosine of the largest turn of a triangle in a collapse
constexpr double kLeastRoundness = 0.1;  ///< of a triangle: 1 if it is equilateral

/// The sum of squared distances from planes, each weighted by its triangle's area.
struct Quadric {
  Eigen::Matrix4d form = Eigen::Matrix4d::Zero();
  double area = 0.0;

  Quadric& operator+=(const Quadric& other) {
    form += other.form;
    area += other.area;
    return *this;
  }
  double MeanSquareAt(const Vec3& p) const {
    const Eigen::Vector4d h = p.homogeneous();
    return std::max(h.dot(form * h), 0.0) / area;
  }
};

/// A move of the vertex `from` onto its neighbour `to`; stale if either has changed since.
struct Collapse {
  double cost;
  std::uint32_t from, to;
  std::uint32_t from_state, to_state;
  /// Cheapest last, for priority_queue.  Ties are ordered, so equal meshes give equal results.
  bool operator<(const Collapse& o) const {
    return std::tie(cost, from, to) > std::tie(o.cost, o.from, o.to);
  }
};

class Simplifier {
 public:
  Simplifier(const TriangleMesh& mesh, double tolerance)
      : mesh_(mesh),
        most_(tolerance * tolerance),
        triangles_(mesh.triangles),
        around_(mesh.vertices.size()),
        quadrics_(mesh.vertices.size()),
        state_(mesh.vertices.size(), 0) {
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
      const Quadric plane = PlaneOf(triangles_[t]);
      for (const std::uint32_t v : triangles_[t]) {
        around_[v].push_back(t);
        quadrics_[v] += plane;
      }
    }
  }

  TriangleMesh Run() {
    for (std::uint32_t v = 0; v < around_.size(); ++v) {
      for (const std::uint32_t w : NeighboursOf(v)) Offer(v, w);
    }
    while (!queue_.empty()) {
      const Collapse next = queue_.top();
      queue_.pop();
      const bool stale = state_[next.from] != next.from_state || state_[next.to] != next.to_state;
      if (!stale && IsAllowed(next.from, next.to)) Apply(next.from, next.to);
    }
    return Rest();
  }

 private:
  using Triangle = std::array<std::uint32_t, 3>;

  static bool Has(const Triangle& t, std::uint32_t v) {
    return t[0] == v || t[1] == v || t[2] == v;
  }
  /// Returns the triangle's normal, whose length is twice its area.
  Vec3 NormalOf(const Triangle& t) const {
    const Vec3& a = mesh_.vertices[t[0]];
    return (mesh_.vertices[t[1]] - a).cross(mesh_.vertices[t[2]] - a);
  }
  double RoundnessOf(const Triangle& t) const {
    double squares = 0.0;
    for (int c = 0; c < 3; ++c) {
      squares += (mesh_.vertices[t[(c + 1) % 3]] - mesh_.vertices[t[c]]).squaredNorm();
    }
    return 2.0 * std::sqrt(3.0) * NormalOf(t).norm() / squares;
  }
  Quadric PlaneOf(const Triangle& t) const {
    const Vec3 normal = NormalOf(t);
    const double area = 0.5 * normal.norm();
    Quadric q;
    if (!(area > 0.0)) return q;
    Eigen::Vector4d plane;
    plane << normal.normalized(), -normal.normalized().dot(mesh_.vertices[t[0]]);
    q.form = area * plane * plane.transpose();
    q.area = area;
    return q;
  }

  std::vector<std::uint32_t> NeighboursOf(std::uint32_t v) const {
    std::vector<std::uint32_t> all;
    for (const std::uint32_t t : around_[v]) {
      for (const std::uint32_t w : triangles_[t]) {
        if (w != v) all.push_back(w);
      }
    }
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    return all;
  }

  void Offer(std::uint32_t v) {
    for (const std::uint32_t w : NeighboursOf(v)) {
      Offer(v, w);
      Offer(w, v);
    }
  }
  void Offer(std::uint32_t from, std::uint32_t to) {
    Quadric both = quadrics_[from];
    both += quadrics_[to];
    const double cost = both.MeanSquareAt(mesh_.vertices[to]);
    if (cost <= most_) queue_.push({cost, from, to, state_[from], state_[to]});
  }

  bool IsAllowed(std::uint32_t from, std::uint32_t to) const {
    // The ends of an edge of a manifold have two common neighbours; with a third, a collapse would
    // pinch the surface.
    const auto a = NeighboursOf(from);
    const auto b = NeighboursOf(to);
    std::vector<std::uint32_t> common;
    std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(common));
    if (common.size() != 2 || a.size() < 4 || b.size() < 4) return false;
    for (const std::uint32_t w : common) {
      if (around_[w].size() < 4) return false;
    }
    for (const std::uint32_t t : around_[from]) {
      const Triangle& now = triangles_[t];
      if (Has(now, to)) continue;
      Triangle then = now;
      std::replace(then.begin(), then.end(), from, to);
      const Vec3 n = NormalOf(now);
      const Vec3 m = NormalOf(then);
      if (n.dot(m) < kLeastCosine * n.norm() * m.norm()) return false;
      if (RoundnessOf(then) < std::min(kLeastRoundness, RoundnessOf(now))) return false;
    }
    return true;
  }

  void Apply(std::uint32_t from, std::uint32_t to) {
    for (const std::uint32_t t : around_[from]) {
      Triangle& triangle = triangles_[t];
      if (Has(triangle, to)) {
        for (const std::uint32_t w : triangle) {
          if (w != from) std::erase(around_[w], t);
        }
      } else {
        std::replace(triangle.begin(), triangle.end(), from, to);
        around_[to].push_back(t);
      }
    }
    around_[from].clear();
    quadrics_[to] += quadrics_[from];
    ++state_[from];
    ++state_[to];
    Offer(to);
  }

  TriangleMesh Rest() const {
    std::vector<std::uint32_t> renamed(around_.size());
    std::vector<bool> left(triangles_.size(), false);
    TriangleMesh out;
    for (std::uint32_t v = 0; v < around_.size(); ++v) {
      if (around_[v].empty()) continue;
      renamed[v] = static_cast<std::uint32_t>(out.vertices.size());
      out.vertices.push_back(mesh_.vertices[v]);
      for (const std::uint32_t t : around_[v]) left[t] = true;
    }
    for (std::uint32_t t = 0; t < triangles_.size(); ++t) {
      if (!left[t]) continue;
      const auto& [a, b, c] = triangles_[t];
      out.triangles.push_back({renamed[a], renamed[b], renamed[c]});
    }
    return out;
  }

  const TriangleMesh& mesh_;
  double most_;
  std::vector<Triangle> triangles_;
  std::vector<std::vector<std::uint32_t>> around_;  ///< triangles at each vertex; empty: it is gone
  std::vector<Quadric> quadrics_;
  std::vector<std::uint32_t> state_;  ///< number of changes of each vertex
  std::priority_queue<Collapse> queue_;
};

}  // namespace

TriangleMesh Simplified(const TriangleMesh& mesh, double tolerance) {
  return Simplifier(mesh, tolerance).Run();
}

}  // namespace palpate
