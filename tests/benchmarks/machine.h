#pragma once

#include <string>

#include "common/program/machine.h"
#include "tests/benchmarks/figures.h"

namespace palpate::bench {

/// What a figure was measured on, as far as it bears on a step's time.
struct Machine : HostMachine {
  std::string simd;  ///< level that the physics chose
};
Machine ThisMachine();
/// {"cpu", "cores", "simd", "compiler"}
Json ToJson(const Machine& machine);

}  // namespace palpate::bench
