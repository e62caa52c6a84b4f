#include "tests/support/planar_rest.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include <Eigen/Geometry>
#include <Eigen/LU>

namespace palpate::test {
namespace {

/// Returns what `normal . x` of the reference point is at least, for each side.
std::vector<double> Bounds(const PlanarFit& fit, double angle) {
  const Eigen::Rotation2Dd turn(angle);
  std::vector<double> bounds;
  for (const PlanarFit::Side& side : fit.sides) {
    const Vec2 normal = turn.inverse() * side.normal;
    double lowest = INFINITY;
    for (const Vec2& v : fit.outline) lowest = std::min(lowest, normal.dot(v));
    bounds.push_back(side.offset - lowest);
  }
  return bounds;
}

struct Nearest {
  double distance;
  PlanarRest rest;
};

/// Returns the free place nearest to the hand at an angle, if there is any: on no side, on one, or
/// where two meet.
std::optional<Nearest> NearestAt(const PlanarFit& fit, const Vec2& hand, double angle) {
  constexpr double kRounding = 1e-14;  // [m]
  const std::vector<double> bounds = Bounds(fit, angle);
  const std::size_t n = bounds.size();
  std::optional<Nearest> best;
  const auto enter = [&](const Vec2& at, std::vector<int> holds, std::vector<double> load) {
    for (std::size_t i = 0; i < n; ++i) {
      if (fit.sides[i].normal.dot(at) < bounds[i] - kRounding) return;
    }
    const double distance = (at - hand).norm();
    if (best && best->distance <= distance) return;
    for (double& l : load) l *= fit.stiffness;
    best = Nearest{distance, {at, angle, std::move(holds), std::move(load)}};
  };
  enter(hand, {}, {});
  for (std::size_t i = 0; i < n && !best; ++i) {
    const Vec2& normal = fit.sides[i].normal;
    const double deep = bounds[i] - normal.dot(hand);
    if (deep >= 0.0) enter(hand + deep * normal, {static_cast<int>(i)}, {deep});
  }
  for (std::size_t i = 0; i < n && !best; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      Eigen::Matrix2d normals;
      normals << fit.sides[i].normal, fit.sides[j].normal;
      if (std::abs(normals.determinant()) < 1e-9) continue;
      const Vec2 at = normals.transpose().inverse() * Vec2(bounds[i], bounds[j]);
      const Vec2 load = normals.inverse() * (at - hand);
      // Nearest means held: the pull lies in the cone of both normals.
      if (load.minCoeff() < 0.0) continue;
      enter(at, {static_cast<int>(i), static_cast<int>(j)}, {load[0], load[1]});
    }
  }
  return best;
}

}  // namespace

double OutBy(const PlanarFit& fit, const Vec2& at, double angle) {
  const std::vector<double> bounds = Bounds(fit, angle);
  double out = -INFINITY;
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    out = std::max(out, bounds[i] - fit.sides[i].normal.dot(at));
  }
  return out;
}

PlanarRest RestOf(const PlanarFit& fit, const Vec2& hand, double hand_angle) {
  const auto energy = [&](double angle) {
    const std::optional<Nearest> nearest = NearestAt(fit, hand, angle);
    const double turn = angle - hand_angle;
    return nearest ? 0.5 * fit.stiffness * nearest->distance * nearest->distance +
                         0.5 * fit.torsional * turn * turn
                   : INFINITY;
  };
  // Mostly nothing turns the outline.
  constexpr double kTurn = 1e-7;
  const double level = energy(hand_angle);
  if (level < energy(hand_angle - kTurn) && level < energy(hand_angle + kTurn)) {
    return NearestAt(fit, hand, hand_angle)->rest;
  }
  // The golden section, within the angles that are free: to both sides of 0, no farther than a
  // tool of this size is turned by its force.
  const double reach = std::abs(hand_angle) + 0.3;
  const auto last_free = [&](double end) {
    double free = 0.0;
    for (double step = end; std::abs(step) > 1e-13; step *= 0.5) {
      if (std::abs(free + step) <= reach && NearestAt(fit, hand, free + step)) free += step;
    }
    return free;
  };
  const double golden = 0.5 * (std::sqrt(5.0) - 1.0);
  double low = last_free(-reach), high = last_free(reach);
  double a = high - golden * (high - low), b = low + golden * (high - low);
  double at_a = energy(a), at_b = energy(b);
  while (high - low > 1e-10) {
    if (at_a < at_b) {
      high = b, b = a, at_b = at_a;
      at_a = energy(a = high - golden * (high - low));
    } else {
      low = a, a = b, at_a = at_b;
      at_b = energy(b = low + golden * (high - low));
    }
  }
  // What the sections only come near to.
  double best = 0.5 * (low + high);
  for (const double angle : {hand_angle, 0.0, low, high}) {
    if (energy(angle) <= energy(best)) best = angle;
  }
  return NearestAt(fit, hand, best)->rest;
}

}  // namespace palpate::test
