#pragma once

#include <string>

namespace palpate::bench {

/// What a figure was measured on, as far as it bears on a step's time.
struct Machine {
  std::string cpu;       ///< as the processor calls itself
  int cores = 0;         ///< that this process may run on
  std::string simd;      ///< level that the physics chose
  std::string compiler;  ///< and whether it optimised
};
Machine ThisMachine();

}  // namespace palpate::bench
