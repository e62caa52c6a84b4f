#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "common/program/machine.h"

namespace palpate::bench {

/// What a figure was measured on, as far as it bears on a step's time.
struct Machine : HostMachine {
  std::string simd;  ///< level that the physics chose
};
Machine ThisMachine();
/// {"cpu", "cores", "simd", "compiler"}
nlohmann::ordered_json ToJson(const Machine& machine);

}  // namespace palpate::bench
