#pragma once

#include <string>

namespace palpate {

/// The host that a figure was measured on, as far as it bears on times.
struct HostMachine {
  std::string cpu;       ///< as the processor calls itself
  int cores = 0;         ///< that this process may run on
  std::string compiler;  ///< of this program, and whether it optimised
};
HostMachine ThisHost();

}  // namespace palpate
