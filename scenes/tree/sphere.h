#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "common/math/pose.h"

namespace palpate {

struct Sphere {
  Vec3 centre = Vec3::Zero();
  double radius = 0.0;
};

/// Returns the smallest ball that contains all the given balls, to rounding; the list must not be
/// empty.  Adds to a basis of at most four balls the one that sticks out most, as in LP-type
/// problems (Fischer & Gärtner, Int. J. Comput. Geom. Appl. 14 (2004) 341-378).
Sphere EnclosingSphere(const std::vector<Sphere>& balls);

/// Finds which of many balls are nearest to a point.  Set-up only: not real-time.
class SphereQuery {
 public:
  explicit SphereQuery(std::vector<Sphere> balls);

  struct Hit {
    std::uint32_t ball = 0;
    /// to the ball's surface, negative inside
    double distance = std::numeric_limits<double>::infinity();
  };
  Hit Nearest(const Vec3& p) const;
  /// Returns the `count` nearest balls, nearest first; fewer if not as many are
  /// nearer than `within`.
  std::vector<std::uint32_t> NearestFew(
      const Vec3& p, std::size_t count,
      double within = std::numeric_limits<double>::infinity()) const;

 private:
  struct Node {
    Vec3 min, max;        ///< box of the centres
    double radius = 0.0;  ///< largest radius
    std::int32_t child = -1;
    std::uint32_t begin = 0, end = 0;
  };
  void Build(std::int32_t node);
  /// Calls visit(ball, distance) for every ball nearer than `within`, and then sets `within`
  /// to its result.
  template <class Visit>
  void Walk(const Vec3& p, double within, Visit visit) const;
  double Bound(const Node& node, const Vec3& p) const;

  std::vector<Sphere> balls_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace palpate
