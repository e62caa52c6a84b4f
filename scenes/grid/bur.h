#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/math/pose.h"

namespace palpate {

/// A point of a bur's surface that represents a patch of it; bur frame T.
struct BurSample {
  Vec3 point = Vec3::Zero();   ///< [m]
  Vec3 normal = Vec3::Zero();  ///< outward, unit
  double area = 0.0;           ///< A [m^2]
  bool cuts = true;            ///< else it is rigid
  /// Direction in which the surface moves at the point, unit; zero: it does not move.
  Vec3 slide = Vec3::Zero();
};

/// A rotating cutter: the solid that a convex curve (rho, z) sweeps when it turns round z,
/// thickened by a radius, the `rounding`.  Frame T: z runs from the tip to the shank, and the
/// origin lies on the axis, one `rounding` above the tip; for a ball, that is its centre.
///
///     rho ^      p2 ______ p3         z
///         |     /        |            |     the curve begins and ends on the axis;
///         |    p1        |            |     the surface lies `rounding` outside of it
///         +---p0--------p4----> z
///
/// A trephine has a closed curve: the profile of its wall, which encloses the bore.
class Bur {
 public:
  static constexpr int kMostPoints = 8;

  /// These throw Error if a length is not above 0, or the rounding exceeds the radius.  [m]
  static Bur Ball(double radius);
  /// Makes a straight fissure bur, flat except for the rounding of its edges.
  static Bur Cylinder(double radius, double length, double rounding);
  /// Makes a tapered fissure bur; an inverted cone if the tip is wider.
  static Bur Cone(double tip_radius, double base_radius, double length, double rounding);
  /// `curve`: (rho, z) [m], convex, from the axis outwards and back to it; one point: a ball.
  /// For a trephine: the closed profile of the wall, from its inner edge at the tip outwards.
  Bur(const std::vector<std::array<double, 2>>& curve, double rounding);

  /// Returns the signed distance of a point of T to the surface, negative inside, and its gradient.
  /// Exact.  Real-time.
  double Distance(const Vec3& p_T, Vec3& gradient_T) const noexcept;

  /// Returns `count` samples of equal area on a spiral of golden angles (Swinbank & Purser, Q. J.
  /// Royal Meteorological Soc. 132 (2006) 1769-1793).  Deterministic.  Set-up.
  std::vector<BurSample> Samples(int count) const;

  bool operator==(const Bur&) const = default;
  double rounding() const { return rounding_; }
  /// Radius of the ball round the origin that contains the bur [m].
  double reach() const { return reach_; }
  /// Lowest z, at the tip; high() is the largest [m].
  double low() const { return points_[0].z - rounding_; }
  double high() const { return high_; }
  double radius() const { return radius_; }
  /// Half of the bur's width; for a trephine, half of its wall's thickness [m].
  double half_width() const { return is_hollow() ? 0.5 * (radius_ - bore_) : radius_; }

 private:
  friend class BurSweep;
  void RequireConvex(std::size_t a, std::size_t b) const;
  struct Point {
    double rho, z;
    bool operator==(const Point&) const = default;
  };
  std::array<Point, kMostPoints> points_{};
  std::array<Point, kMostPoints> normals_{};  ///< outward, of the segment from point i to the next
  std::array<double, kMostPoints> inverse_squared_{};  ///< 1 / (length of that segment)^2
  int count_ = 0;
  double rounding_ = 0.0, reach_ = 0.0, radius_ = 0.0, high_ = 0.0;
  double bore_ = 0.0;  ///< radius of the bore; 0: there is none

  bool is_hollow() const { return bore_ > 0.0; }
};

}  // namespace palpate
