#pragma once

#include <cstdint>
#include <vector>

#include "common/math/pose.h"
#include "scenes/scene.h"

namespace palpate::test {

struct HandOptions {
  std::uint64_t seed = 1;
  double speed = 0.1;  ///< mean [m/s]; a rotation counts as its angle times half the tool's radius
  int steps = 20000;   ///< samples, one per millisecond
  double press_mm = 4.0;  ///< greatest depth of pressing; the least is half of it
};

/// Makes a random hand, for which nothing was tuned: poses X_WH of a scene's first tool that
/// approaches from anywhere, presses 2 to 4 mm deep (or as the options say), slides, turns,
/// squeezes, taps, leaves, and comes again.
///
///    approach          slide               turn           squeeze        tap        leave
///       \                                   __
///        \             . . . . .           (  )            ~ ~ ~         | |          /
///   ______v______   __/_________\__   ____( __ )____   ____~_~_~____   __v_v_____   __/______
///         press     2-4 mm below the                   and against     in and
///                   touching pose                      what is there   out
///
/// Touching poses are found from the meshes alone, without the step: the tool advances towards the
/// objects by its distance from them until it touches (conservative advancement;
/// MeshOracle::Distance), and the hand is placed below that pose by its depth.  Moves pass through
/// such poses on cubic splines with a minimum-jerk speed (Flash & Hogan, J. Neurosci. 5 (1985)
/// 1688) and at most 30 m/s^2, which a quick hand reaches; so short moves are slower than the mean,
/// and long ones faster.  The acceleration is only exceeded if the requested mean is otherwise out
/// of reach, above some 0.2 m/s.
///
/// These lengths hold for tools and objects of 10 mm to 1 m, and scale in proportion outside of
/// that. The first pose is free of contact.  The same options give the same bits everywhere.
/// Throws Error if the tool can reach no touching pose in the scene.
std::vector<Pose> MakeHand(const Scene& scene, const HandOptions& options);

}  // namespace palpate::test
