#pragma once

#include <array>

#include "scenes/grid/bur.h"

namespace palpate {

/// The volume that a bur sweeps on its way x + t step, 0 <= t <= 1, without turning.  Frame T is
/// that of its start.  Real-time.  Gives the same bits with every instruction set.  Computes in
/// floats, as the fields that are cut are stored: within 10 mm the rounding is some 1e-9 m.
class BurSweep {
 public:
  /// The number of lattice points in a row.
  static constexpr int kRow = 8;
  using Row = std::array<float, kRow>;

  BurSweep(const Bur& bur, const Vec3& step_T);

  /// Computes the distances of a row of points, `apart_T` from each other, to the swept volume.
  /// Because the bur is convex, t -> distance is convex: the distances at both ends and their
  /// slopes tell whether the nearest place lies between them, and then regula falsi on the slope
  /// finds it.  For a trephine this holds as long as the same side of its wall stays nearest, so
  /// its steps must be short.
  /// The result is never below the true distance.  It is exact for a ball, whose way is a capsule,
  /// and at the ends of the way.  For other burs it is too large by at most a twentieth of the
  /// step's length, where the slope jumps: deep inside, below sharp edges.
  /// `within`: points farther away than this get their distance to the end of the way.
  void Distances(const Vec3& first_T, const Vec3& apart_T, float within,
                 Row& distance) const noexcept;
  double Distance(const Vec3& p_T) const noexcept {
    Row distance;
    Distances(p_T, Vec3::Zero(), 1e18f, distance);
    return distance[0];
  }

  /// phi <- max(phi, -distance), up to the band, at the points of a row.
  /// `room`: no point below the band rises before the bur has gone this much farther than the end
  /// of this step [m].
  struct Raised {
    bool any;
    float room;
  };
  Raised Raise(const Vec3& first_T, const Vec3& apart_T, float band, float* phi,
               bool wide = IsWide()) const noexcept;
  bool IsOfBall() const { return curve_.count == 1; }
  /// Returns whether the processor has AVX2, with which a row is one vector.
  static bool IsWide();

  /// The bur's curve, as in Bur, and its step.
  struct Curve {
    float rho[Bur::kMostPoints], z[Bur::kMostPoints];
    float rho_normal[Bur::kMostPoints], z_normal[Bur::kMostPoints];
    float inverse_squared[Bur::kMostPoints];
    int count;
    bool hollow;
    float rounding, step[3], step_squared, inverse_step_squared;
  };

 private:
  Curve curve_;
};

}  // namespace palpate
