#include "tests/support/triangle_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "tests/support/exact_orientation.h"
#include "tests/support/random.h"

namespace palpate::test {
namespace {

constexpr std::uint32_t kPerLeaf = 2;

bool Less(const Vec3& a, const Vec3& b) {
  for (int i = 0; i < 3; ++i) {
    if (a[i] != b[i]) return a[i] < b[i];
  }
  return false;
}

}  // namespace

TriangleTree::Box TriangleTree::BoxOf(std::span<const Vec3> points) {
  Vec3 low = Vec3::Constant(INFINITY), high = -low;
  for (const Vec3& p : points) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  // Enlarged a little against rounding, so that no point is outside.
  const Vec3 slack = 1e-15 * low.cwiseAbs().cwiseMax(high.cwiseAbs());
  return {0.5 * low + 0.5 * high, 0.5 * (high - low) + slack};
}

TriangleTree::TriangleTree(const TriangleMesh& mesh)
    : vertices_(mesh.vertices), triangles_(mesh.triangles) {
  order_.resize(triangles_.size());
  std::iota(order_.begin(), order_.end(), 0u);
  std::vector<Vec3> centroids;
  centroids.reserve(triangles_.size());
  for (const auto& t : triangles_) {
    centroids.push_back((vertices_[t[0]] + vertices_[t[1]] + vertices_[t[2]]) / 3.0);
  }
  if (triangles_.empty()) return;
  nodes_.push_back({{}, -1, 0, static_cast<std::uint32_t>(order_.size())});
  Build(0, centroids);
  closed_ = IsClosed();
}

void TriangleTree::Build(std::size_t node, std::vector<Vec3>& centroids) {
  const std::uint32_t begin = nodes_[node].begin, end = nodes_[node].end;
  std::vector<Vec3> points;
  Vec3 low = Vec3::Constant(INFINITY), high = -low;
  for (std::uint32_t i = begin; i < end; ++i) {
    for (const std::uint32_t v : triangles_[order_[i]]) points.push_back(vertices_[v]);
    low = low.cwiseMin(centroids[order_[i]]);
    high = high.cwiseMax(centroids[order_[i]]);
  }
  nodes_[node].box = BoxOf(points);
  if (end - begin <= kPerLeaf) return;
  int axis = 0;
  (high - low).maxCoeff(&axis);
  const std::uint32_t middle = begin + (end - begin) / 2;
  const auto at = [&](std::uint32_t i) { return order_.begin() + i; };
  std::nth_element(at(begin), at(middle), at(end), [&](std::uint32_t a, std::uint32_t b) {
    return std::pair(centroids[a][axis], a) < std::pair(centroids[b][axis], b);
  });
  const std::size_t child = nodes_.size();
  nodes_[node].child = static_cast<std::int32_t>(child);
  nodes_.push_back({{}, -1, begin, middle});
  nodes_.push_back({{}, -1, middle, end});
  Build(child, centroids);
  Build(child + 1, centroids);
}

bool TriangleTree::IsClosed() const {
  // Vertices at one place get one number.
  std::vector<std::uint32_t> by_place(vertices_.size()), place(vertices_.size());
  std::iota(by_place.begin(), by_place.end(), 0u);
  std::sort(by_place.begin(), by_place.end(),
            [&](std::uint32_t a, std::uint32_t b) { return Less(vertices_[a], vertices_[b]); });
  for (std::size_t i = 0; i < by_place.size(); ++i) {
    const bool same = i > 0 && vertices_[by_place[i]] == vertices_[by_place[i - 1]];
    place[by_place[i]] = same ? place[by_place[i - 1]] : by_place[i];
  }
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> passes;
  for (const auto& t : triangles_) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = place[t[i]], b = place[t[(i + 1) % 3]];
      passes[std::minmax(a, b)] += a < b ? 1 : a > b ? -1 : 0;
    }
  }
  return std::all_of(passes.begin(), passes.end(),
                     [](const auto& edge) { return edge.second == 0; });
}

bool TriangleTree::Contains(const Vec3& p) const {
  if (empty() || !root().box.Overlaps({p, Vec3::Zero()})) return false;
  // Casts a segment to a point outside; each triangle that it crosses counts with its sign.  A
  // segment through an edge or a corner is ambiguous, so another direction is tried.
  const double reach = 4.0 * (root().box.half.norm() + 1e-30);
  Random random(0x5eed);
  for (int tries = 0; tries < 1000; ++tries) {
    const Vec3 q = p + reach * random.Direction();
    int winding = 0;
    bool clear = true, on_surface = false;
    const auto visit = [&](const auto& self, const Node& node) -> void {
      // The segment against the box, by the axes of the box and those across the segment.
      const Vec3 half = 0.5 * (q - p), middle = 0.5 * (p + q) - node.box.center;
      const Vec3 reach_of = half.cwiseAbs();
      const double slack = 1e-12 * reach;
      if ((middle.cwiseAbs() - reach_of - node.box.half).maxCoeff() > slack) return;
      const Vec3 across = middle.cross(half).cwiseAbs();
      for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        if (across[i] >
            node.box.half[j] * reach_of[k] + node.box.half[k] * reach_of[j] + slack * reach) {
          return;
        }
      }
      if (!node.leaf()) {
        self(self, first(node));
        self(self, second(node));
        return;
      }
      for (const std::uint32_t triangle : TrianglesOf(node)) {
        const Triangle t = At(triangle);
        on_surface |= Meet(t, {p, p, p});
        const int of_p = Orient3d(t[0], t[1], t[2], p), of_q = Orient3d(t[0], t[1], t[2], q);
        if (of_p == of_q) {
          // Beside the plane; or in it, where only a triangle that the segment meets would count.
          if (of_p == 0 && Meet(t, {p, q, q})) clear = false;
          continue;
        }
        const int s0 = Orient3d(p, q, t[0], t[1]), s1 = Orient3d(p, q, t[1], t[2]),
                  s2 = Orient3d(p, q, t[2], t[0]);
        if (s0 == s1 && s1 == s2 && s0 != 0 && of_p != 0 && of_q != 0) {
          winding += of_p > 0 ? 1 : -1;
        } else if (Meet(t, {p, q, q})) {
          clear = false;
        }
      }
    };
    visit(visit, root());
    // Orient3d is positive behind a face: out through it leaves the inside.
    if (on_surface) return false;
    if (clear) return winding > 0;
  }
  return false;  // all of a thousand directions were ambiguous: p is practically on an edge
}

double TriangleTree::Distance(const Vec3& p, double within, Vec3* nearest) const {
  double least = within;
  bool found = false;
  const Box point{p, Vec3::Zero()};
  const auto visit = [&](const auto& self, const Node& node) -> void {
    if (node.leaf()) {
      for (const std::uint32_t triangle : TrianglesOf(node)) {
        const Vec3 foot = NearestPoint(At(triangle), p);
        const double distance = (p - foot).norm();
        if (distance < least) {
          least = distance;
          found = true;
          if (nearest != nullptr) *nearest = foot;
        }
      }
      return;
    }
    const Node *near = &first(node), *far = &second(node);
    double near_distance = near->box.Distance(point), far_distance = far->box.Distance(point);
    if (far_distance < near_distance) {
      std::swap(near, far);
      std::swap(near_distance, far_distance);
    }
    if (near_distance < least) self(self, *near);
    if (far_distance < least) self(self, *far);
  };
  if (!empty()) visit(visit, root());
  return found ? least : std::numeric_limits<double>::infinity();
}

}  // namespace palpate::test
