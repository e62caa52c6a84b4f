#include "scenes/shapes/bur_shapes.h"

#include <algorithm>
#include <cmath>

#include "scenes/shapes/swept_mesh.h"

namespace palpate {
namespace {

constexpr int kSides = 32;
/// Directions of a quarter of the outline: 16 leave a ball of 1.4 mm within 1 um.
constexpr int kQuarter = 16;
constexpr double kShank = 0.8e-3, kHandle = 4e-3;  ///< radii [m]; a shank after ISO 1797

/// Where the outline, the curve made thicker, is farthest in a direction (cos a, sin a): (rho, y).
std::array<double, 2> Farthest(const BurProfile& bur, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  const auto along = [&](const std::array<double, 2>& p) { return p[0] * c + p[1] * s; };
  const auto& p =
      *std::max_element(bur.curve.begin(), bur.curve.end(),
                        [&](const auto& a, const auto& b) { return along(a) < along(b); });
  return {p[0] + bur.rounding * c, p[1] + bur.rounding * (s + 1.0)};
}

}  // namespace

BurProfile BallBur(double radius) {
  return {{{0.0, 0.0}}, radius};
}

BurProfile ConeBur(double tip_radius, double top_radius, double length, double rounding) {
  rounding = std::min({rounding, tip_radius, top_radius, 0.4 * length});
  const double top = length - 2.0 * rounding;
  BurProfile bur{{{0.0, 0.0}}, rounding};
  if (tip_radius > rounding) bur.curve.push_back({tip_radius - rounding, 0.0});
  if (top_radius > rounding) bur.curve.push_back({top_radius - rounding, top});
  bur.curve.push_back({0.0, top});
  return bur;
}

TriangleMesh MakeBur(const BurProfile& bur, double handle) {
  std::vector<Vec3> curve;
  std::vector<double> radii;
  const auto add = [&](double y, double radius) {
    // Flat ends: a rod's points are all different.
    if (!curve.empty()) y = std::max(y, curve.back().y() + 1e-6);
    curve.emplace_back(0.0, y, 0.0);
    radii.push_back(radius);
  };
  const double widest = Farthest(bur, 0.0)[0], top = Farthest(bur, 0.5 * M_PI)[1];
  const double shank = std::min(kShank, 0.6 * widest);
  for (int i = 1; i <= 2 * kQuarter; ++i) {
    const double angle = 0.5 * M_PI * (static_cast<double>(i) / kQuarter - 1.0);
    const auto [rho, y] = Farthest(bur, angle);
    if (angle > 0.0 && rho < shank) break;
    if (rho > 0.02 * widest) add(y, rho);
  }
  add(top, shank);
  add(top + 2e-3, shank);
  add(top + 6e-3, kShank);
  add(top + 14e-3, kShank);
  add(top + 16e-3, 0.6 * kHandle);
  add(top + 20e-3, kHandle);
  add(std::max(handle, top + 22e-3), kHandle);
  return MakeRod(curve, radii, kSides);
}

}  // namespace palpate
