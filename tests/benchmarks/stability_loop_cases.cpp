// The step within its loops: the servo loop with a bad link, and an arm and hand with delay.
#include <algorithm>
#include <cmath>
#include <deque>

#include <spdlog/fmt/fmt.h>

#include "common/dds/wire.h"
#include "common/math/rotation.h"
#include "devices/simulated/simulated_phantom.h"
#include "devices/wrench_limiter.h"
#include "server/session/servo_loop.h"
#include "tests/benchmarks/stability_case.h"
#include "tests/support/random.h"

namespace palpate::bench {
namespace {

using test::Random;

constexpr double kMillimetre = 1e-3;

Solid Floor() {
  return Box({60 * kMillimetre, 10 * kMillimetre, 60 * kMillimetre}, 2048,
             {Vec3(0, -5 * kMillimetre, 0), Quat::Identity()});
}

}  // namespace

std::vector<StabilityCase> LoopCases() {
  return {};
}

}  // namespace palpate::bench
