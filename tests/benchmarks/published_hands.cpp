#include "common/error.h"
#include "tests/benchmarks/closed_loop_run.h"

namespace palpate::bench {

const std::vector<PublishedHand>& PublishedHands() {
  static const std::vector<PublishedHand> hands{
      {"van-beek",
       "van Beek, Bergmann Tiest, Mugge & Kappers, Scientific Reports 5 (2015) 18004, Fig. 3: one "
       "trial of one participant; its rotation is an estimate",
       HandImpedance{}},
      {"light", "estimate: two fingers on a stylus, a quarter of van-beek's",
       HandImpedance{.mass_kg = 0.14, .damping_N_s_m = 1.6, .stiffness_N_m = 34.0}},
      {"firm", "estimate: a tense arm, three times van-beek's damping and stiffness",
       HandImpedance{.damping_N_s_m = 19.4, .stiffness_N_m = 405.0}},
  };
  return hands;
}

const PublishedHand& PublishedHandOf(const std::string& name) {
  std::string names;
  for (const PublishedHand& hand : PublishedHands()) {
    if (hand.name == name) return hand;
    names += " " + hand.name;
  }
  throw UsageError("closed-loop: no hand '" + name + "'; there are" + names);
}

}  // namespace palpate::bench
