#pragma once

#include <string>

#include "common/program/machine.h"
#include "tests/benchmarks/figures.h"

namespace palpate::bench {

/// The properties of the machine that affect the time of a step.
struct Machine : HostMachine {
  std::string simd;  ///< instruction set that the physics chose
};
Machine ThisMachine();
/// {"cpu", "cores", "simd", "compiler"}
Json ToJson(const Machine& machine);

}  // namespace palpate::bench
