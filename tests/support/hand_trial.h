#pragma once

#include <cstdint>
#include <string>

#include "scenes/scene.h"
#include "tests/support/contact_figures.h"
#include "tests/support/hand_path.h"

namespace palpate::test {

/// Hands over a scene, and what must hold of each.
struct HandTrial {
  std::uint64_t first_seed = 1, last_seed = 5;
  double speed = 0.1;  ///< [m/s]
  int steps = 2000;    ///< of each hand
  ContactChecks checks{.oracle_every = 1,
                       .converge_every = 0,
                       .settle_every = 200,
                       .hold_far = true,
                       .quarter_steps = true,
                       .progress = {}};
  ContactLimits limits;
};

/// Drives the scene's first tool by one hand after the other.
/// @returns what does not hold, a paragraph for each seed, which it begins with; empty where all
/// holds: EXPECT_EQ(TryHands(scene, {...}), "").  `palpate-bench hands --seed` runs such a hand
/// again.
std::string TryHands(const Scene& scene, const HandTrial& trial);

}  // namespace palpate::test
