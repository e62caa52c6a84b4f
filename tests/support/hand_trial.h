#pragma once

#include <cstdint>
#include <string>

#include "scenes/scene.h"
#include "tests/support/contact_figures.h"
#include "tests/support/hand_path.h"

namespace palpate::test {

/// Random hands in a scene, and the limits that each must keep.
struct HandTrial {
  std::uint64_t first_seed = 1, last_seed = 5;
  double speed = 0.1;  ///< [m/s]
  int steps = 2000;    ///< samples of each hand
  ContactChecks checks{.oracle_every = 1,
                       .converge_every = 0,
                       .settle_every = 200,
                       .hold_far = true,
                       .quarter_steps = true,
                       .progress = {}};
  ContactLimits limits;
};

/// Drives the scene's first tool with one hand after the other.
/// @returns the broken limits, a paragraph per seed, which begins with the seed; empty if all hold:
/// EXPECT_EQ(TryHands(scene, {...}), "").  `palpate-bench hands --seed` repeats such a hand.
std::string TryHands(const Scene& scene, const HandTrial& trial);

}  // namespace palpate::test
