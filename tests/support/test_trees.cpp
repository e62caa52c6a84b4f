#include "tests/support/test_trees.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace palpate::test {
namespace {

struct Range {
  int begin, end;
};

}  // namespace

SphereTree MakeTree(std::span<const Ball> balls) {
  std::vector<Ball> sorted(balls.begin(), balls.end());
  int depth = 1;
  for (std::size_t room = kTreeArity; room < sorted.size(); room *= kTreeArity) ++depth;

  // Ranges of one level, each cut into at most eight of the next by halving three times.
  std::vector<std::vector<Range>> ranges(1, {{0, static_cast<int>(sorted.size())}});
  std::vector<std::vector<std::vector<Range>>> children;
  for (int l = 0; l < depth; ++l) {
    children.emplace_back();
    std::vector<Range> next;
    for (const Range& range : ranges.back()) {
      std::vector<Range> parts{range};
      for (int halving = 0; halving < 3; ++halving) {
        std::vector<Range> halves;
        for (const Range& part : parts) {
          if (part.end - part.begin < 2) {
            halves.push_back(part);
            continue;
          }
          Vec3 low = Vec3::Constant(1e30), high = -low;
          for (int i = part.begin; i < part.end; ++i) {
            low = low.cwiseMin(sorted[static_cast<std::size_t>(i)].center);
            high = high.cwiseMax(sorted[static_cast<std::size_t>(i)].center);
          }
          int axis = 0;
          (high - low).maxCoeff(&axis);
          const int middle = (part.begin + part.end) / 2;
          std::stable_sort(
              sorted.begin() + part.begin, sorted.begin() + part.end,
              [axis](const Ball& a, const Ball& b) { return a.center[axis] < b.center[axis]; });
          halves.push_back({part.begin, middle});
          halves.push_back({middle, part.end});
        }
        parts = halves;
      }
      children.back().push_back(parts);
      next.insert(next.end(), parts.begin(), parts.end());
    }
    ranges.push_back(next);
  }

  SphereTree tree;
  for (const Ball& ball : sorted) {
    tree.leaf_x.push_back(ball.center.x());
    tree.leaf_y.push_back(ball.center.y());
    tree.leaf_z.push_back(ball.center.z());
    tree.leaf_radius.push_back(ball.radius);
    tree.centroid += ball.center / static_cast<double>(sorted.size());
    tree.leaf_triangle_begin.push_back(0);
  }
  tree.leaf_triangle_begin.push_back(0);
  tree.level_begin.push_back(0);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (int l = 0; l < depth; ++l) {
    int next_index = 0;
    for (const std::vector<Range>& parts : children[static_cast<std::size_t>(l)]) {
      SpherePacket packet;
      for (int lane = 0; lane < kTreeArity; ++lane) {
        packet.x[lane] = packet.y[lane] = packet.z[lane] = packet.radius[lane] = nan;
        packet.child[lane] = -1;
        if (lane >= static_cast<int>(parts.size())) continue;
        const Range part = parts[static_cast<std::size_t>(lane)];
        Vec3 mean = Vec3::Zero();
        for (int i = part.begin; i < part.end; ++i) {
          mean += sorted[static_cast<std::size_t>(i)].center / (part.end - part.begin);
        }
        packet.x[lane] = static_cast<float>(mean.x());
        packet.y[lane] = static_cast<float>(mean.y());
        packet.z[lane] = static_cast<float>(mean.z());
        const Vec3 c(packet.x[lane], packet.y[lane], packet.z[lane]);
        double radius = 0.0;
        for (int i = part.begin; i < part.end; ++i) {
          const Ball& ball = sorted[static_cast<std::size_t>(i)];
          radius = std::max(radius, (ball.center - c).norm() + ball.radius);
        }
        packet.radius[lane] =
            std::nextafter(static_cast<float>(radius), std::numeric_limits<float>::infinity());
        packet.child[lane] = l + 1 == depth ? part.begin : next_index;
        ++next_index;
      }
      tree.packets.push_back(packet);
    }
    tree.level_begin.push_back(static_cast<std::int32_t>(tree.packets.size()));
  }
  return tree;
}

std::vector<Ball> RandomBalls(Random& random, int count, double half, double radius) {
  std::vector<Ball> balls;
  for (int i = 0; i < count; ++i) {
    const Vec3 c = random.InCube(half);
    balls.push_back({c, random.Uniform(0.3, 1.7) * radius});
  }
  return balls;
}

std::vector<Ball> Floor(double half, double spacing, double radius) {
  std::vector<Ball> balls;
  for (double x = -half; x <= half; x += spacing) {
    for (double y = -half; y <= half; y += spacing) balls.push_back({Vec3(x, y, -radius), radius});
  }
  return balls;
}

std::vector<Ball> Shell(int count, double outer, double radius) {
  std::vector<Ball> balls;
  for (int i = 0; i < count; ++i) {  // Fibonacci lattice
    const double z = 1.0 - 2.0 * (i + 0.5) / count;
    const double a = 2.39996322972865332 * i;
    const double s = std::sqrt(1.0 - z * z);
    balls.push_back({(outer - radius) * Vec3(s * std::cos(a), s * std::sin(a), z), radius});
  }
  return balls;
}

}  // namespace palpate::test
