#include "tests/benchmarks/sliding_path.h"

#include <cmath>
#include <utility>

namespace palpate::bench {
namespace {

/// @param at  point of the surface and its normal at a share, 0 to 1, of the path.
template <class At>
SlidingPath Slide(At at, int steady_steps) {
  constexpr int kDescent = 240, kRest = 60;  // 6 mm at 25 mm/s, then time to settle
  constexpr double kAbove = 0.005;
  SlidingPath path;
  const auto add = [&](double share, double height) {
    const auto [point, normal] = at(share);
    path.hand.push_back(point + (kSlidingBallRadius + height) * normal);
    path.normal.push_back(normal);
  };
  for (int i = 0; i < kDescent; ++i) {
    add(0.0, kAbove - (kAbove + kSlidingDepth) * i / kDescent);
  }
  for (int i = 0; i < kRest; ++i) add(0.0, -kSlidingDepth);
  path.steady = path.hand.size();
  for (int i = 1; i <= steady_steps; ++i)
    add(static_cast<double>(i) / steady_steps, -kSlidingDepth);
  return path;
}

}  // namespace

SlidingPath SlideOverCube(int steady_steps) {
  return Slide(
      [](double share) {
        return std::pair(Vec3(0.8 * kCubeSide * (share - 0.5), 0.5 * kCubeSide, 0.0),
                         Vec3(Vec3::UnitY()));
      },
      steady_steps);
}

SlidingPath SlideOverEllipsoid(int steady_steps) {
  return Slide(
      [](double share) {
        const double angle = M_PI * (150.0 - 120.0 * share) / 180.0;
        const Vec3 unit(std::cos(angle), std::sin(angle), 0.0);
        return std::pair(Vec3(kEllipsoidAxes.cwiseProduct(unit)),
                         Vec3(unit.cwiseQuotient(kEllipsoidAxes).normalized()));
      },
      steady_steps);
}

}  // namespace palpate::bench
