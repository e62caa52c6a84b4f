#include "tests/benchmarks/overlap_oracle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace palpate::bench {

std::vector<OverlapOracle::Cell> OverlapOracle::IntoCells(std::vector<Ball>& balls) {
  Vec3 low = balls.front().center, high = low;
  for (const Ball& ball : balls) {
    low = low.cwiseMin(ball.center);
    high = high.cwiseMax(ball.center);
  }
  // About a dozen balls a cell, were they spread over the box; big and small balls apart, so that
  // one big ball does not make a cell reach far.
  const double size =
      std::max(1e-9, (high - low).maxCoeff()) / std::cbrt(static_cast<double>(balls.size()));
  std::map<std::array<int, 4>, std::vector<Ball>> grid;
  for (const Ball& ball : balls) {
    const Vec3 i = (ball.center - low) / (1.5 * size);
    grid[{static_cast<int>(i.x()), static_cast<int>(i.y()), static_cast<int>(i.z()),
          static_cast<int>(std::floor(2.0 * std::log2(ball.radius)))}]
        .push_back(ball);
  }
  std::vector<Cell> cells;
  balls.clear();
  for (const auto& [index, members] : grid) {
    Cell cell{Vec3::Zero(), 0.0, static_cast<int>(balls.size()), 0};
    for (const Ball& ball : members) {
      cell.center += ball.center / static_cast<double>(members.size());
    }
    for (const Ball& ball : members) {
      cell.radius = std::max(cell.radius, (ball.center - cell.center).norm() + ball.radius);
      balls.push_back(ball);
    }
    cell.radius += 1e-9;
    cell.end = static_cast<int>(balls.size());
    cells.push_back(cell);
  }
  return cells;
}

OverlapOracle::OverlapOracle(const SphereTree& tool, const std::vector<Body>& objects) {
  const auto add = [](const SphereTree& tree, const Pose& X, std::vector<Ball>& balls) {
    for (std::size_t i = 0; i < tree.leaves(); ++i) {
      balls.push_back(
          {X * Vec3(tree.leaf_x[i], tree.leaf_y[i], tree.leaf_z[i]), tree.leaf_radius[i]});
    }
  };
  add(tool, Pose{}, tool_);
  for (const Body& object : objects) add(object.tree, object.X_WB, objects_);
  tool_cells_ = IntoCells(tool_);
  object_cells_ = IntoCells(objects_);
}

OverlapOracle::Overlap OverlapOracle::At(const Pose& X_WT) const {
  Overlap overlap;
  const Mat3 R = X_WT.q.toRotationMatrix();
  std::vector<Ball> moved;
  for (const Cell& cell : tool_cells_) {
    const Vec3 center = R * cell.center + X_WT.p;
    moved.clear();
    for (const Cell& other : object_cells_) {
      const double reach = cell.radius + other.radius;
      if ((center - other.center).squaredNorm() > reach * reach) continue;
      if (moved.empty()) {
        for (int i = cell.begin; i < cell.end; ++i) {
          const Ball& ball = tool_[static_cast<std::size_t>(i)];
          moved.push_back({R * ball.center + X_WT.p, ball.radius});
        }
      }
      for (const Ball& ball : moved) {
        for (int j = other.begin; j < other.end; ++j) {
          const Ball& object = objects_[static_cast<std::size_t>(j)];
          const double sum = ball.radius + object.radius;
          const double distance2 = (ball.center - object.center).squaredNorm();
          if (distance2 >= sum * sum) continue;
          overlap.depth = std::max(overlap.depth, sum - std::sqrt(distance2));
          ++overlap.pairs;
        }
      }
    }
  }
  return overlap;
}

}  // namespace palpate::bench
