#pragma once

#include <cstddef>
#include <vector>

#include "common/math/pose.h"

namespace palpate::bench {

// The experiment of chapter 2.5.1 (Figs. 2.16-2.18): a ball is pressed 1 mm into an analytic object
// and slides over it in the x-y plane, without rotation.
inline constexpr double kSlidingBallRadius = 0.005;     ///< [m]
inline constexpr double kSlidingDepth = 1e-3;           ///< commanded [m]
inline constexpr double kSlidingStiffness = 1000.0;     ///< k_t [N/m]: the true force is 1 N
inline constexpr double kCubeSide = 0.050;              ///< [m]
inline const Vec3 kEllipsoidAxes{0.040, 0.025, 0.030};  ///< semi-axes [m]

/// The hand's motion, one sample per millisecond, and the force that it should feel.  The ball's
/// centre is commanded kSlidingDepth below the object's offset surface, so the god-object is the
/// point above it on that surface, and the true force is 1 N along the exact normal.
struct SlidingPath {
  std::vector<Vec3> hand;    ///< commanded centre of the ball, in W [m]
  std::vector<Vec3> normal;  ///< exact outward normal, the direction of the true force
  std::size_t steady = 0;    ///< first sample of steady sliding; the ball comes down before it
};

/// Slides along the middle of the cube's top face, 20 mm to both sides.
SlidingPath SlideOverCube(int steady_steps);
/// Slides over the top of the ellipsoid, between the parameters 150 and 30 degrees of its section.
SlidingPath SlideOverEllipsoid(int steady_steps);

}  // namespace palpate::bench
