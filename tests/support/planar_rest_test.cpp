#include "tests/support/planar_rest.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/support/random.h"

namespace palpate::test {
namespace {

constexpr double kSpring = 1000.0, kTurning = 1.0;

PlanarFit Groove(double half_angle, std::vector<Vec2> outline) {
  const double s = std::sin(half_angle), c = std::cos(half_angle);
  return {{{{-c, s}, 0.0}, {{c, s}, 0.0}}, std::move(outline), kSpring, kTurning};
}

std::vector<Vec2> Regular(int corners, double radius) {
  std::vector<Vec2> outline;
  for (int i = 0; i < corners; ++i) {
    const double angle = 2.0 * M_PI * i / corners;
    outline.push_back(radius * Vec2(std::cos(angle), std::sin(angle)));
  }
  return outline;
}

/// A prism of n sides in its hole, which is wider by a gap on each side.
PlanarFit Peg(int corners, double radius, double gap) {
  PlanarFit fit{{}, Regular(corners, radius), kSpring, kTurning};
  const double apothem = radius * std::cos(M_PI / corners);
  for (int i = 0; i < corners; ++i) {
    const double angle = 2.0 * M_PI * (i + 0.5) / corners;
    fit.sides.push_back({-Vec2(std::cos(angle), std::sin(angle)), -(apothem + gap)});
  }
  return fit;
}

TEST(PlanarRest, IsFreeAndHasNoMoreEnergyThanAnyFreePoseAround) {
  Random random(3);
  for (int trial = 0; trial < 300; ++trial) {
    const PlanarFit fit = trial % 2 == 0
                              ? Peg(3 + random.Below(6), 0.01, random.Uniform(5e-6, 1e-4))
                              : Groove(random.Uniform(0.4, 1.3), Regular(4, 0.005));
    const Vec2 hand(random.Uniform(-3e-3, 3e-3), random.Uniform(-3e-3, 3e-3));
    const double hand_angle = random.Uniform(-0.1, 0.1);
    const auto energy = [&](const Vec2& at, double angle) {
      return 0.5 * kSpring * (at - hand).squaredNorm() +
             0.5 * kTurning * (angle - hand_angle) * (angle - hand_angle);
    };
    const PlanarRest rest = RestOf(fit, hand, hand_angle);
    ASSERT_LT(OutBy(fit, rest.at, rest.angle), 1e-12);
    Vec2 push = Vec2::Zero();
    for (std::size_t i = 0; i < rest.holds.size(); ++i) {
      ASSERT_GE(rest.load[i], 0.0);
      push += rest.load[i] * fit.sides[static_cast<std::size_t>(rest.holds[i])].normal;
    }
    EXPECT_LT((push - kSpring * (rest.at - hand)).norm(), 1e-8);
    const double least = energy(rest.at, rest.angle);
    for (int i = 0; i < 300; ++i) {
      const double near = std::pow(10.0, random.Uniform(-7.0, -2.0));
      const Vec2 at = rest.at + near * Vec2(random.Uniform(-1, 1), random.Uniform(-1, 1));
      const double angle = rest.angle + 100.0 * near * random.Uniform(-1.0, 1.0);
      if (std::abs(angle) > 0.3 || OutBy(fit, at, angle) > 0.0) continue;
      ASSERT_GT(energy(at, angle), least - 1e-12) << "trial " << trial;
    }
  }
}

}  // namespace
}  // namespace palpate::test
