#pragma once

#include <string>

#include "common/machine.h"

namespace palpate::bench {

/// What a figure was measured on, as far as it bears on a step's time.
struct Machine : HostMachine {
  std::string simd;  ///< level that the physics chose
};
Machine ThisMachine();

}  // namespace palpate::bench
