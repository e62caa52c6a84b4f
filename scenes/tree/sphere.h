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

/// Smallest ball that holds all the given balls, to rounding; the list must not be empty.  Grows a
/// basis of at most four balls by the one that sticks out most, as an LP-type problem (Fischer &
/// Gärtner, Int. J. Comput. Geom. Appl. 14 (2004) 341-378).
Sphere EnclosingSphere(const std::vector<Sphere>& balls);

/// Which of many balls is nearest to a point.  Set-up only: not real-time.
class SphereQuery {
 public:
  explicit SphereQuery(std::vector<Sphere> balls);

  struct Hit {
    std::uint32_t ball = 0;
    double distance = std::numeric_limits<double>::infinity();  ///< to its surface, < 0 inside
  };
  Hit Nearest(const Vec3& p) const;
  /// The `count` nearest, nearest first; fewer where there are not as many nearer than `within`.
  std::vector<std::uint32_t> NearestFew(
      const Vec3& p, std::size_t count,
      double within = std::numeric_limits<double>::infinity()) const;

 private:
  struct Node {
    Vec3 min, max;        ///< box of the centres
    double radius = 0.0;  ///< largest
    std::int32_t child = -1;
    std::uint32_t begin = 0, end = 0;
  };
  void Build(std::int32_t node);
  /// Shows visit(ball, distance) every ball nearer than `within`, which is then what it returned.
  template <class Visit>
  void Walk(const Vec3& p, double within, Visit visit) const;
  double Bound(const Node& node, const Vec3& p) const;

  std::vector<Sphere> balls_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

}  // namespace palpate
