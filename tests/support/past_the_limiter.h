#pragma once

#include "devices/simulated/simulated_phantom.h"

namespace palpate::test {

/// Drives a simulated arm with a wrench that did not come from a WrenchLimiter, to measure a
/// limiter's effect.  This is not possible for any other device, and no product code includes
/// this header.
class PastTheLimiter {
 public:
  static void Apply(SimulatedPhantom& arm, const Wrench& wrench) noexcept { arm.Pass(wrench); }
};

}  // namespace palpate::test
