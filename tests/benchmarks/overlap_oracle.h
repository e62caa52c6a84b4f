#pragma once

#include <span>
#include <vector>

#include "common/math/pose.h"
#include "scenes/scene.h"

namespace palpate::bench {

/// Deepest overlap of a tool's leaf balls with the objects', at any pose, to the last bit of
/// double. Shares nothing with the sphere trees or the query that it checks: balls are kept in the
/// cells of a plain grid, cells whose boxes are apart are passed over, and within the rest every
/// pair is tried.
class OverlapOracle {
 public:
  OverlapOracle(const SphereTree& tool, const std::vector<Body>& objects);

  struct Overlap {
    double depth = 0.0;  ///< deepest, 0 where nothing overlaps [m]
    long pairs = 0;      ///< balls that overlap
  };
  Overlap At(const Pose& X_WT) const;

 private:
  struct Ball {
    Vec3 center;
    double radius;
  };
  struct Cell {
    Vec3 center;
    double radius;  ///< of a ball around the cell's balls
    int begin, end;
  };
  static std::vector<Cell> IntoCells(std::vector<Ball>& balls);

  std::vector<Ball> tool_, objects_;
  std::vector<Cell> tool_cells_, object_cells_;
};

}  // namespace palpate::bench
