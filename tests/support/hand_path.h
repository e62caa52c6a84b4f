#pragma once

#include <cstdint>
#include <vector>

#include "common/math/pose.h"
#include "scenes/scene.h"

namespace palpate::test {

struct HandOptions {
  std::uint64_t seed = 1;
  double speed = 0.1;  ///< mean over the path [m/s]; turning by an angle counts as half the tool's
                       ///< radius times it
  int steps = 20000;   ///< samples, one a millisecond
  double press_mm = 4.0;  ///< it presses half as deep to as deep as this
};

/// A hand that nobody tuned to: X_WH of a scene's first tool, as it comes from anywhere, presses 2
/// to 4 mm deep or as deep as it is told, slides, turns, squeezes, taps, leaves, and comes again.
///
///    approach          slide               turn           squeeze        tap        leave
///       \                                   __
///        \             . . . . .           (  )            ~ ~ ~         | |          /
///   ______v______   __/_________\__   ____( __ )____   ____~_~_~____   __v_v_____   __/______
///         press     2-4 mm below the                   and against     in and
///                   touching pose                      what is there   out
///
/// Each place is found by the meshes alone, without the step: the tool is moved towards the objects
/// by its distance from them until it touches (conservative advancement; MeshOracle::Distance), and
/// the hand is put below that by its depth.  Moves go through such places on cubic splines, with
/// the speed of least jerk (Flash & Hogan, J. Neurosci. 5 (1985) 1688), and 30 m/s^2 at most, which
/// a quick hand reaches; so the shortest moves are slower than the mean, and the others faster.
/// Only where the mean that is asked cannot be reached so, above some 0.2 m/s, is it more.
///
/// Lengths are as said for tools and objects of 10 mm to 1 m, and in proportion below and above.
/// The first pose is free.  The same options give the same bits everywhere.
/// Throws Error where a scene offers no place that the tool can come to.
std::vector<Pose> MakeHand(const Scene& scene, const HandOptions& options);

}  // namespace palpate::test
