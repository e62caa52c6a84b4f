#include "tests/benchmarks/overlap_oracle.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "server/physics/tree/sphere_tree_query.h"

namespace palpate::bench {

std::vector<OverlapOracle::Ball> OverlapOracle::IntoCells(std::vector<Ball>& balls,
                                                          double per_cell) {
  Vec3 low = balls.front().center, high = low;
  for (const Ball& ball : balls) {
    low = low.cwiseMin(ball.center);
    high = high.cwiseMax(ball.center);
  }
  const double size = std::max(1e-9, (high - low).maxCoeff()) *
                      std::cbrt(per_cell / static_cast<double>(balls.size()));
  // Sorted by size too, so that a big ball does not extend the reach of a cell of small ones.
  std::map<std::array<int, 4>, std::vector<Ball>> grid;
  for (const Ball& ball : balls) {
    const Vec3 i = (ball.center - low) / size;
    grid[{static_cast<int>(i.x()), static_cast<int>(i.y()), static_cast<int>(i.z()),
          static_cast<int>(std::floor(std::log2(ball.radius)))}]
        .push_back(ball);
  }
  std::vector<Ball> cells;
  balls.clear();
  for (const auto& [index, members] : grid) {
    Ball cell{Vec3::Zero(), 0.0, static_cast<int>(balls.size()), 0};
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

OverlapOracle::Side OverlapOracle::Sort(std::vector<Ball> leaves) {
  Side side;
  side.leaves = std::move(leaves);
  // A mesh fills a small part of its bounding box, so occupied cells hold more than the average.
  side.cells = IntoCells(side.leaves, 1.0);
  side.groups = IntoCells(side.cells, 2.0);
  return side;
}

OverlapOracle::OverlapOracle(const SphereTree& tool, const std::vector<Body>& objects,
                             const Features& features) {
  const auto add = [](const SphereTree& tree, const Pose& X, const auto& core_depth,
                      std::vector<Ball>& balls) {
    for (std::size_t i = 0; i < tree.leaves(); ++i) {
      balls.push_back({X * Vec3(tree.leaf_x[i], tree.leaf_y[i], tree.leaf_z[i]),
                       tree.leaf_radius[i] - core_depth(i), static_cast<int>(balls.size())});
    }
  };
  std::vector<Ball> balls;
  add(
      tool, Pose{}, [](std::size_t) { return 0.0; }, balls);
  tool_ = Sort(std::move(balls));
  balls.clear();
  for (const Body& object : objects) {
    const auto core_depth = [&](std::size_t leaf) {
      if (!features.compliance || object.materials.empty()) return 0.0;
      const std::size_t material = object.leaf_material.empty() ? 0 : object.leaf_material[leaf];
      return CoreDepth(object.materials[material], object.tree.leaf_radius[leaf]);
    };
    add(object.tree, object.X_WB, core_depth, balls);
  }
  objects_ = Sort(std::move(balls));
}

OverlapOracle::Overlap OverlapOracle::At(const Pose& X_WT) const {
  Overlap overlap;
  const Mat3 R = X_WT.q.toRotationMatrix();
  const auto move = [&](const Ball& ball) { return Vec3(R * ball.center + X_WT.p); };
  const auto touch = [](const Vec3& center, const Ball& ball, const Ball& other) {
    const double reach = ball.radius + other.radius;
    return (center - other.center).squaredNorm() < reach * reach;
  };
  const auto each = [](const std::vector<Ball>& balls, const Ball& of, auto&& visit) {
    for (int i = of.begin; i < of.end; ++i) visit(balls[static_cast<std::size_t>(i)]);
  };
  for (const Ball& group : tool_.groups) {
    const Vec3 group_center = move(group);
    for (const Ball& other_group : objects_.groups) {
      if (!touch(group_center, group, other_group)) continue;
      each(tool_.cells, group, [&](const Ball& cell) {
        const Vec3 cell_center = move(cell);
        if (!touch(cell_center, cell, other_group)) return;
        each(objects_.cells, other_group, [&](const Ball& other_cell) {
          if (!touch(cell_center, cell, other_cell)) return;
          each(tool_.leaves, cell, [&](const Ball& leaf) {
            const Vec3 leaf_center = move(leaf);
            if (!touch(leaf_center, leaf, other_cell)) return;
            each(objects_.leaves, other_cell, [&](const Ball& other) {
              if (!touch(leaf_center, leaf, other)) return;
              overlap.depth = std::max(
                  overlap.depth, leaf.radius + other.radius - (leaf_center - other.center).norm());
              ++overlap.pairs;
            });
          });
        });
      });
    }
  }
  return overlap;
}

}  // namespace palpate::bench
