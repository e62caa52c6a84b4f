#pragma once

#include <vector>

#include <Eigen/Core>

namespace palpate::test {

using Vec2 = Eigen::Vector2d;

/// A rigid outline among flat sides, in the plane, drawn by the springs of a coupling: what a prism
/// or a ball in a groove or in a hole along z is.
struct PlanarFit {
  struct Side {
    Vec2 normal;    ///< unit, away from the material
    double offset;  ///< all points x of the outline have normal . x >= offset [m]
  };
  std::vector<Side> sides;    ///< at the separation that the tool keeps
  std::vector<Vec2> outline;  ///< corners, from the reference point [m]
  double stiffness;           ///< k_t [N/m]
  double torsional;           ///< k_r [N m/rad]
};

struct PlanarRest {
  Vec2 at;                   ///< the reference point [m]
  double angle;              ///< [rad]
  std::vector<int> holds;    ///< the sides that it rests on with a force: none, one or two
  std::vector<double> load;  ///< of each of them [N]
};

/// Returns by how much the outline is out of the sides' free space, negative inside [m].
double OutBy(const PlanarFit& fit, const Vec2& at, double angle);

/// Returns the pose of least energy k_t/2 |x - hand|^2 + k_r/2 (a - hand_angle)^2 of all in which
/// the outline is free.
/// Precondition: it is free somewhere at the angle 0; along the angle the energy is convex, as it
/// is while k_r is over the force times the outline's reach.
PlanarRest RestOf(const PlanarFit& fit, const Vec2& hand, double hand_angle);

}  // namespace palpate::test
