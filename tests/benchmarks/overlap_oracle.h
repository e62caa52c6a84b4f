#pragma once

#include <vector>

#include "common/math/pose.h"
#include "scenes/scene.h"

namespace palpate::bench {

/// Computes the deepest overlap of a tool's leaf balls with the objects' at any pose, to the last
/// bit of a double.  If the scene declares compliance, a soft leaf counts only as its rigid core.
/// Shares no code with the sphere trees or the query that it checks: balls are sorted into the
/// cells of a plain grid, and cells into those of a coarser one; cells that are apart are skipped,
/// and in the others every pair is tested.
class OverlapOracle {
 public:
  OverlapOracle(const SphereTree& tool, const std::vector<Body>& objects, const Features& features);

  struct Overlap {
    double depth = 0.0;  ///< deepest overlap; 0 if there is none [m]
    long pairs = 0;      ///< number of pairs of balls that overlap
  };
  Overlap At(const Pose& X_WT) const;

 private:
  /// A ball, or a ball around the members [begin, end) of the next finer list; a leaf's `begin` is
  /// its number among the leaves of its side.
  struct Ball {
    Vec3 center;
    double radius;
    int begin = 0, end = 0;
  };
  struct Side {
    std::vector<Ball> leaves, cells, groups;
  };
  static std::vector<Ball> IntoCells(std::vector<Ball>& balls, double per_cell);
  static Side Sort(std::vector<Ball> leaves);

  Side tool_, objects_;
};

}  // namespace palpate::bench
