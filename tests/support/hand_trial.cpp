#include "tests/support/hand_trial.h"

#include <spdlog/fmt/fmt.h>

namespace palpate::test {

std::string TryHands(const Scene& scene, const HandTrial& trial) {
  std::string broken;
  for (std::uint64_t seed = trial.first_seed; seed <= trial.last_seed; ++seed) {
    const std::vector<Pose> X_WH =
        MakeHand(scene, {.seed = seed, .speed = trial.speed, .steps = trial.steps});
    const std::string lines = BrokenLimits(MeasureContact(scene, X_WH, trial.checks), trial.limits);
    if (lines.empty()) continue;
    broken +=
        fmt::format("seed {} at {} m/s, {} steps:\n{}", seed, trial.speed, trial.steps, lines);
  }
  return broken;
}

}  // namespace palpate::test
