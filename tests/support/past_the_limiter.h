#pragma once

#include "devices/simulated/simulated_phantom.h"

namespace palpate::test {

/// Drives a simulated arm with a wrench that no WrenchLimiter limited, to measure a limiter's
/// effect. No other device allows this, and no product code includes this header.
class PastTheLimiter {
 public:
  static void Apply(SimulatedPhantom& arm, const Wrench& wrench) noexcept { arm.Pass(wrench); }
};

}  // namespace palpate::test
