#include "server/physics/surface/box_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>

#include <Eigen/Eigenvalues>

namespace palpate {
namespace {

using Triangles = std::span<std::uint32_t>;

/// Principal axes of a patch, by the second moments of its area; of its corners where it has none.
Mat3 PrincipalAxes(const ContactMesh& mesh, Triangles patch) {
  Mat3 moments = Mat3::Zero();
  Vec3 sum = Vec3::Zero();
  double area = 0.0;
  const Vec3& origin = mesh.Corner(patch[0], 0);
  for (std::uint32_t t : patch) {
    const Vec3 a = mesh.Corner(t, 0) - origin, b = mesh.Corner(t, 1) - origin,
               c = mesh.Corner(t, 2) - origin;
    const double weight = (b - a).cross(c - a).norm() + 1e-300;
    const Vec3 all = a + b + c;
    // Of a uniform triangle: (9 m m^T + a a^T + b b^T + c c^T) / 12, m its middle.
    moments += weight / 12.0 *
               (all * all.transpose() + a * a.transpose() + b * b.transpose() + c * c.transpose());
    sum += weight / 3.0 * all;
    area += weight;
  }
  moments = moments / area - (sum / area) * (sum / area).transpose();
  const double scale = moments.trace();
  if (!(scale > 0.0)) return Mat3::Identity();
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(moments / scale);
  return solver.info() == Eigen::Success ? Mat3(solver.eigenvectors()) : Mat3(Mat3::Identity());
}

}  // namespace

BoxTree::BoxTree(const ContactMesh& mesh) {
  const std::size_t count = mesh.triangles().size();
  leaf_parent_.assign(count, -1);
  for (std::uint32_t t = 0; t < count; ++t) {
    const Vec3 centre = (mesh.Corner(t, 0) + mesh.Corner(t, 1) + mesh.Corner(t, 2)) / 3.0;
    double radius = 0.0;
    for (int c = 0; c < 3; ++c) radius = std::max(radius, (mesh.Corner(t, c) - centre).norm());
    leaf_centre_.push_back(centre);
    leaf_corners_.emplace_back();
    for (int c = 0; c < 3; ++c) leaf_corners_.back().col(c) = mesh.Corner(t, c);
    leaf_radius_.push_back(radius);
  }
  if (count < 2) return;
  std::vector<std::uint32_t> order(count);
  std::iota(order.begin(), order.end(), 0u);
  boxes_.reserve(count - 1);
  struct Work {
    Triangles patch;
    Node parent;
    int side;
  };
  std::vector<Work> left{{order, -1, 0}};
  while (!left.empty()) {
    const Work work = left.back();
    left.pop_back();
    const auto attach = [&](Node node) {
      if (work.parent >= 0) {
        boxes_[static_cast<std::size_t>(work.parent)].child[work.side] = node;
      }
    };
    if (work.patch.size() == 1) {
      attach(~static_cast<Node>(work.patch[0]));
      leaf_parent_[work.patch[0]] = work.parent;
      continue;
    }
    Box box{};
    box.parent = work.parent;
    const Mat3 axes = PrincipalAxes(mesh, work.patch);
    Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (std::uint32_t t : work.patch) {
      for (int c = 0; c < 3; ++c) {
        const Vec3 x = axes.transpose() * mesh.Corner(t, c);
        low = low.cwiseMin(x);
        high = high.cwiseMax(x);
      }
    }
    // A billionth of the size for the rounding of the axes, which are orthogonal to 1e-15.
    const Vec3 half = (0.5 * (high - low)).array() + 1e-9 * (high - low).maxCoeff();
    std::array<int, 3> order_of{0, 1, 2};
    std::sort(order_of.begin(), order_of.end(),
              [&](int a, int b) { return half[a] != half[b] ? half[a] < half[b] : a < b; });
    for (int c = 0; c < 3; ++c) {
      const int k = order_of[static_cast<std::size_t>(c)];
      box.sides.col(c) = half[k] * axes.col(k);
    }
    box.centre = axes * (0.5 * (low + high));
    for (std::uint32_t t : work.patch) {
      for (int c = 0; c < 3; ++c) {
        box.radius = std::max(box.radius, (mesh.Corner(t, c) - box.centre).norm());
      }
    }
    const double shortest = half[order_of[0]];
    box.scale = shortest > 0.0 ? 1.0 / shortest : 0.0;
    const auto node = static_cast<Node>(boxes_.size());
    attach(node);
    boxes_.push_back(box);
    // Halved across its longest side.
    const Vec3 axis = axes.col(order_of[2]);
    std::sort(work.patch.begin(), work.patch.end(), [&](std::uint32_t a, std::uint32_t b) {
      const double x = axis.dot(leaf_centre_[a]), y = axis.dot(leaf_centre_[b]);
      return x != y ? x < y : a < b;
    });
    const std::size_t middle = work.patch.size() / 2;
    left.push_back({work.patch.subspan(middle), node, 1});
    left.push_back({work.patch.first(middle), node, 0});
  }
}

}  // namespace palpate
