#include "tests/benchmarks/mesh_overlap.h"

#include <algorithm>
#include <cmath>

namespace palpate::bench {
namespace {

constexpr std::size_t kPerLeaf = 4;

/// Positive inside.
double DepthOf(const Vec3& p, const MeshQuery& in) {
  const double distance = in.Nearest(p).distance;
  return in.Inside(p) ? distance : -distance;
}

}  // namespace

MeshOverlap::VertexTree::VertexTree(const TriangleMesh& mesh) : vertices(mesh.vertices) {
  while (leaves * kPerLeaf < vertices.size()) leaves *= 2;
  balls.resize(2 * leaves - 1);
  const auto build = [&](const auto& self, std::size_t node, std::size_t begin,
                         std::size_t end) -> void {
    const auto at = [&](std::size_t i) { return vertices.begin() + static_cast<long>(i); };
    Vec3 low = Vec3::Constant(INFINITY), high = -low;
    for (std::size_t i = begin; i < end; ++i) {
      low = low.cwiseMin(vertices[i]);
      high = high.cwiseMax(vertices[i]);
    }
    Ball& ball = balls[node];
    ball = {0.5 * (low + high), 0.0};
    for (std::size_t i = begin; i < end; ++i) {
      ball.radius = std::max(ball.radius, (vertices[i] - ball.center).norm());
    }
    if (node >= leaves - 1) return;
    int axis = 0;
    (high - low).maxCoeff(&axis);
    const std::size_t middle = begin + (end - begin) / 2;
    std::nth_element(at(begin), at(middle), at(end),
                     [axis](const Vec3& a, const Vec3& b) { return a[axis] < b[axis]; });
    self(self, 2 * node + 1, begin, middle);
    self(self, 2 * node + 2, middle, end);
  };
  build(build, 0, 0, vertices.size());
}

MeshOverlap::MeshOverlap(const TriangleMesh& tool, const std::vector<Body>& objects)
    : tool_(tool), tool_query_(tool) {
  for (const Body& object : objects) {
    objects_.push_back(
        std::make_unique<Object>(VertexTree(object.mesh), MeshQuery(object.mesh), object.X_WB));
  }
}

void MeshOverlap::Deepen(const VertexTree& tree, const Pose& X, const MeshQuery& in,
                         double& depth) {
  const auto visit = [&](const auto& self, std::size_t node, std::size_t begin,
                         std::size_t end) -> void {
    const VertexTree::Ball& ball = tree.balls[node];
    if (DepthOf(X * ball.center, in) + ball.radius <= depth) return;
    if (node >= tree.leaves - 1) {
      for (std::size_t i = begin; i < end; ++i) {
        depth = std::max(depth, DepthOf(X * tree.vertices[i], in));
      }
      return;
    }
    const std::size_t middle = begin + (end - begin) / 2;
    self(self, 2 * node + 1, begin, middle);
    self(self, 2 * node + 2, middle, end);
  };
  visit(visit, 0, 0, tree.vertices.size());
}

double MeshOverlap::At(const Pose& X_WT) const {
  double depth = 0.0;
  for (const auto& object : objects_) {
    const Pose X_BT = object->X_WB.Inverse() * X_WT;
    Deepen(tool_, X_BT, object->query, depth);
    Deepen(object->vertices, X_BT.Inverse(), tool_query_, depth);
  }
  return depth;
}

}  // namespace palpate::bench
