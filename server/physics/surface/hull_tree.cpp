#include "server/physics/surface/hull_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <future>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include <Eigen/Eigenvalues>

namespace palpate {
namespace {

using Triangles = std::span<std::uint32_t>;

/// A patch of more eights of corners has its box instead: to go through this many costs as much as
/// two further looks at its halves, taken.
constexpr std::size_t kMostEights = 32;
/// Half a patch of so many triangles is built in a thread of its own: a tenth of a second.  Taken.
constexpr std::size_t kOwnThread = 1 << 17;

/// Principal axes of a patch, by the second moments of its area; of its corners where it has none.
Mat3 PrincipalAxes(const std::vector<Mat3>& corners, Triangles patch) {
  Mat3 moments = Mat3::Zero();
  Vec3 sum = Vec3::Zero();
  double area = 0.0;
  const Vec3 origin = corners[patch[0]].col(0);
  for (std::uint32_t t : patch) {
    const Vec3 a = corners[t].col(0) - origin, b = corners[t].col(1) - origin,
               c = corners[t].col(2) - origin;
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

HullTree::HullTree(const ContactMesh& mesh) {
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
  inner_.resize(count - 1);
  struct Work {
    Triangles patch;
    Node node, parent;
    int side;
  };
  const std::function<void(const Work&)> build = [&](const Work& top) {
    std::vector<Work> left{top};
    std::vector<std::future<void>> others;
    std::vector<std::pair<double, std::uint32_t>> along;  // of a patch's triangles
    while (!left.empty()) {
      const Work work = left.back();
      left.pop_back();
      const auto attach = [&](Node node) {
        if (work.parent >= 0) {
          inner_[static_cast<std::size_t>(work.parent)].child[work.side] = node;
        }
      };
      if (work.patch.size() == 1) {
        attach(~static_cast<Node>(work.patch[0]));
        leaf_parent_[work.patch[0]] = work.parent;
        continue;
      }
      Inner box{};
      box.parent = work.parent;
      const Mat3 axes = PrincipalAxes(leaf_corners_, work.patch);
      Vec3 low = Vec3::Constant(std::numeric_limits<double>::infinity()), high = -low;
      for (std::uint32_t t : work.patch) {
        for (int c = 0; c < 3; ++c) {
          const Vec3 x = axes.transpose() * leaf_corners_[t].col(c);
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
          box.radius = std::max(box.radius, (leaf_corners_[t].col(c) - box.centre).squaredNorm());
        }
      }
      box.radius = std::sqrt(box.radius);
      const Node node = work.node;
      attach(node);
      inner_[static_cast<std::size_t>(node)] = box;
      // Halved across its longest side.
      const Vec3 axis = axes.col(order_of[2]);
      along.clear();
      for (std::uint32_t t : work.patch) along.emplace_back(axis.dot(leaf_centre_[t]), t);
      std::sort(along.begin(), along.end());
      std::ranges::transform(along, work.patch.begin(), [](const auto& at) { return at.second; });
      const std::size_t middle = work.patch.size() / 2;
      // A patch of n triangles has n - 1 inner nodes, the first half's before the second's.
      const Work second{work.patch.subspan(middle), node + static_cast<Node>(middle), node, 1};
      if (second.patch.size() >= kOwnThread) {
        others.push_back(std::async(build, second));  // where there is no thread: at get()
      } else {
        left.push_back(second);
      }
      left.push_back({work.patch.first(middle), node + 1, node, 0});
    }
    for (std::future<void>& other : others) other.get();
  };
  build({order, 0, -1, 0});
  corners_.resize(inner_.size());
  if (const std::vector<Vec3> all = Gather(root()); !all.empty()) AddEight(root(), all);
}

/// The corners below a node, each once, where they are no more than eight; else none, and they have
/// been added to points_.
std::vector<Vec3> HullTree::Gather(Node node) {
  std::vector<Vec3> few;
  const auto add = [&few](const Vec3& x) {
    if (std::find(few.begin(), few.end(), x) == few.end()) few.push_back(x);
  };
  if (IsLeaf(node)) {
    for (int c = 0; c < 3; ++c) add(leaf_corners_[TriangleOf(node)].col(c));
    return few;
  }
  const std::size_t first = points_.size();
  const auto& child = inner(node).child;
  const std::vector<Vec3> below[2] = {Gather(child[0]), Gather(child[1])};
  if (!below[0].empty() && !below[1].empty()) {
    for (const std::vector<Vec3>& of_child : below)
      std::for_each(of_child.begin(), of_child.end(), add);
    if (few.size() <= 8) return few;
  }
  for (int side = 0; side < 2; ++side) {
    if (!below[side].empty()) AddEight(child[side], below[side]);
  }
  const std::size_t eights = points_.size() - first;
  corners_[static_cast<std::size_t>(node)] = {
      static_cast<std::uint32_t>(first),
      eights <= kMostEights ? static_cast<std::uint32_t>(eights) : 0u, 0xff};
  return {};
}

/// The corners of a node that nobody has added yet; the last is repeated to make eight.
void HullTree::AddEight(Node node, const std::vector<Vec3>& corners) {
  EightPoints& eight = points_.emplace_back();
  for (std::size_t k = 0; k < 8; ++k) {
    const Vec3& x = corners[std::min(k, corners.size() - 1)];
    for (int c = 0; c < 3; ++c) eight.x[c][k] = x[c];
  }
  Assign(node, static_cast<std::uint32_t>(points_.size() - 1));
}

/// To a node and all below it their lanes of an eight; returns the node's, a bit each.
std::uint32_t HullTree::Assign(Node node, std::uint32_t eight) {
  std::uint32_t lanes = 0;
  if (!IsLeaf(node)) {
    for (const Node child : inner(node).child) lanes |= Assign(child, eight);
    corners_[static_cast<std::size_t>(node)] = {eight, 1, lanes};
    return lanes;
  }
  const EightPoints& points = points_[eight];
  for (unsigned k = 0; k < 8; ++k) {
    const Vec3 x(points.x[0][k], points.x[1][k], points.x[2][k]);
    for (int c = 0; c < 3; ++c) {
      if (x == leaf_corners_[TriangleOf(node)].col(c)) lanes |= 1u << k;
    }
  }
  return lanes;
}

Vec3 HullTree::Lowest(Node node, const Vec3& m, const Kernels& kernels) const {
  if (IsLeaf(node)) {
    const Mat3& x = leaf_corners_[TriangleOf(node)];
    int best = 0;
    double least = m.dot(x.col(0));
    for (int c = 1; c < 3; ++c) {
      const double along = m.dot(x.col(c));
      if (along < least) best = c;
      least = std::min(along, least);
    }
    return x.col(best);
  }
  const Corners& corners = corners_[static_cast<std::size_t>(node)];
  if (corners.eights > 0) {
    const EightPoints* const points = points_.data() + corners.first;
    const int best =
        kernels.lowest_point(points, static_cast<int>(corners.eights), corners.lanes, m.data());
    const EightPoints& eight = points[best / 8];
    return {eight.x[0][best % 8], eight.x[1][best % 8], eight.x[2][best % 8]};
  }
  const Inner& inner = inner_[static_cast<std::size_t>(node)];
  Vec3 corner = inner.centre;
  for (int c = 0; c < 3; ++c) {
    const Vec3 side = inner.sides.col(c);
    corner += m.dot(side) < 0.0 ? side : Vec3(-side);
  }
  return corner;
}

}  // namespace palpate
