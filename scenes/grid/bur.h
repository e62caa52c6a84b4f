#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/math/pose.h"

namespace palpate {

/// A point of a bur's surface that stands for a patch of it; bur frame T.
struct BurSample {
  Vec3 point = Vec3::Zero();   ///< [m]
  Vec3 normal = Vec3::Zero();  ///< outward, unit
  double area = 0.0;           ///< A [m^2]
  bool cuts = true;            ///< else it is rigid
  /// Where the surface goes there, unit; 0: it stands still.
  Vec3 slide = Vec3::Zero();
};

/// A rotating cutter: what a convex curve (rho, z) sweeps when it turns round z, made thicker by a
/// radius.  Frame T: z runs from the tip to the shank, and the origin lies on the axis, one
/// `rounding` above the tip: the centre of a ball.
///
///     rho ^      p2 ______ p3         z
///         |     /        |            |     the curve begins and ends on the axis;
///         |    p1        |            |     the surface lies `rounding` outside of it
///         +---p0--------p4----> z
///
/// Of a trephine the curve is closed: it goes round the wall, and within lies the bore.
class Bur {
 public:
  static constexpr int kMostPoints = 8;

  /// Throw Error where a length is not above 0, or the rounding is more than the radius.  [m]
  static Bur Ball(double radius);
  /// Straight fissure bur, flat but for the rounding of its edges.
  static Bur Cylinder(double radius, double length, double rounding);
  /// Tapered fissure bur, inverted where the tip is the wider.
  static Bur Cone(double tip_radius, double base_radius, double length, double rounding);
  /// `curve`: (rho, z) [m], convex, from the axis outwards and back to it; one point: a ball.  Or a
  /// wall's: from its inner edge at the tip outwards, and round to where it began.
  Bur(const std::vector<std::array<double, 2>>& curve, double rounding);

  /// Distance of a point of T to the surface, below 0 within, and its gradient.  Exact.  Real-time.
  double Distance(const Vec3& p_T, Vec3& gradient_T) const noexcept;

  /// `count` samples of the same area on a spiral of golden angles (Swinbank & Purser, Q. J. Royal
  /// Meteorological Soc. 132 (2006) 1769-1793).  Deterministic.  Set-up.
  std::vector<BurSample> Samples(int count) const;

  bool operator==(const Bur&) const = default;
  double rounding() const { return rounding_; }
  /// All of it is within so much of the origin [m].
  double reach() const { return reach_; }
  /// z from tip to top [m].
  double low() const { return points_[0].z - rounding_; }
  double high() const { return high_; }
  double radius() const { return radius_; }
  /// Half of what it is wide, or its wall where it is hollow [m].
  double half_width() const { return is_hollow() ? 0.5 * (radius_ - bore_) : radius_; }

 private:
  friend class BurSweep;
  void RequireConvex(std::size_t a, std::size_t b) const;
  struct Point {
    double rho, z;
    bool operator==(const Point&) const = default;
  };
  std::array<Point, kMostPoints> points_{};
  std::array<Point, kMostPoints> normals_{};  ///< outward, of the piece from point i to the next
  std::array<double, kMostPoints> inverse_squared_{};  ///< of its length
  int count_ = 0;
  double rounding_ = 0.0, reach_ = 0.0, radius_ = 0.0, high_ = 0.0;
  double bore_ = 0.0;  ///< its radius; 0: there is none

  bool is_hollow() const { return bore_ > 0.0; }
};

}  // namespace palpate
