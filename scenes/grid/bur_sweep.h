#pragma once

#include <array>

#include "scenes/grid/bur.h"

namespace palpate {

/// What a bur passes on its way x + t step, 0 <= t <= 1, without turning.  Frame T is that of its
/// beginning.  Real-time.  The same bits by whatever instructions.  In floats, as the fields that
/// are cut: of points within 10 mm rounding takes some 1e-9 m.
class BurSweep {
 public:
  /// Points of a lattice in a row.
  static constexpr int kRow = 8;
  using Row = std::array<float, kRow>;

  BurSweep(const Bur& bur, const Vec3& step_T);

  /// Distances of points in a row, `apart_T` from each other, to all that the bur passes: t ->
  /// distance is convex, for the bur is, and so two distances with their slopes tell whether the
  /// nearest place lies between, where regula falsi on the slope finds it.  Never below the truth.
  /// Of a trephine it is convex as far as one side of its wall is the nearest: steps are short.
  /// Outside of a ball within 1e-4 of the step's length above it, and within a twentieth where
  /// slopes leap: deep within, below sharp edges.  Exact at the way's ends.
  /// `within`: farther points get their distance to the way's end.
  void Distances(const Vec3& first_T, const Vec3& apart_T, float within,
                 Row& distance) const noexcept;
  double Distance(const Vec3& p_T) const noexcept {
    Row distance;
    Distances(p_T, Vec3::Zero(), 1e18f, distance);
    return distance[0];
  }

  /// phi <- max(phi, -distance), up to the band, at the points of a row.
  /// `room`: by which no point below the band is sooner raised than the bur has gone so much
  /// farther than this step's end [m].
  struct Raised {
    bool any;
    float room;
  };
  Raised Raise(const Vec3& first_T, const Vec3& apart_T, float band, float* phi,
               bool wide = IsWide()) const noexcept;
  bool IsOfBall() const { return curve_.count == 1; }
  /// Whether the processor has AVX2, by which a row is one vector.
  static bool IsWide();

  /// Its curve, as Bur has it, and its step.
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
