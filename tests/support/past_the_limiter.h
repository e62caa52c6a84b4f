#pragma once

#include "devices/simulated/simulated_phantom.h"

namespace palpate::test {

/// Drives a simulated arm by a wrench that no WrenchLimiter made, to measure what a limiter does.
/// There is no such way to any other device, and no product's code sees this header.
class PastTheLimiter {
 public:
  static void Apply(SimulatedPhantom& arm, const Wrench& wrench) noexcept { arm.Pass(wrench); }
};

}  // namespace palpate::test
