#include "tests/support/simulated_link.h"

#include <algorithm>

namespace palpate::test {

LinkDice::Arrivals LinkDice::Send(std::int64_t now_ns, const LinkConditions& conditions) {
  // All dice are thrown for each sample, so that no probability affects the others' outcomes.
  const auto up_to = [this](std::int64_t most_ns) {
    return static_cast<std::int64_t>(random_.Uniform(0.0, 1.0) * static_cast<double>(most_ns));
  };
  const bool lost = random_.Uniform(0.0, 1.0) < conditions.loss;
  const std::int64_t jitter_ns = up_to(conditions.jitter_ns);
  const bool held_back = random_.Uniform(0.0, 1.0) < conditions.reordering;
  const std::int64_t hold_ns = up_to(conditions.straggle_ns);
  const bool doubled = random_.Uniform(0.0, 1.0) < conditions.duplication;
  const std::int64_t copy_ns = up_to(conditions.straggle_ns);

  Arrivals arrivals;
  if (lost) return arrivals;
  std::int64_t time_ns = std::max(now_ns + conditions.delay_ns + jitter_ns, queue_ends_ns_);
  if (held_back) {
    time_ns += hold_ns;
  } else {
    queue_ends_ns_ = time_ns;
  }
  arrivals.time_ns[arrivals.count++] = time_ns;
  if (doubled) arrivals.time_ns[arrivals.count++] = time_ns + copy_ns;
  return arrivals;
}

}  // namespace palpate::test
